# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node's parameter file, read without ROS: the same robots, settings and checks."""
from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from math import inf, nan
from pathlib import Path
import re
from typing import Any

import yaml

from .setting import most_like
from .settings import NODE, NodeSettings, OF_TIP, ROBOT, RobotSettings
from ..errors import ParameterError, ToolError

NODE_NAME = 'kinematic_state_publisher'
PARAMETERS = 'ros__parameters'
OF_ROS = re.compile(r'use_sim_time|start_type_description_service|qos_overrides\..+')
"""Parameters that every node of ROS has."""

Pairs = tuple[tuple[Any, Any], ...]
"""A mapping with the keys that are given twice: ROS takes both."""


WORDS = {spelt: value for word, value in (('y', True), ('yes', True), ('true', True), ('on', True),
                                          ('n', False), ('no', False), ('false', False),
                                          ('off', False))
         for spelt in (word, word.capitalize(), word.upper())}
"""What ROS's parser takes for truth values."""


class _Loader(yaml.SafeLoader):
    """YAML as ROS's own parser takes it: 1e-3 is a number, and 2026-01-01 is text."""

    yaml_implicit_resolvers = {}

    def pairs(self, node: yaml.MappingNode) -> Pairs:
        """Return a mapping as it is written."""
        return tuple(
            (str(key.value), self.construct_object(value, deep=True)) for key, value in node.value)

    def scalar(self, node: yaml.ScalarNode) -> Any:
        """Return a truth value, a number or text; None where nothing stands."""
        text: str = node.value
        if node.style or text in WORDS:
            return text if node.style else WORDS[text]
        for convert in (partial(int, base=0), float):
            try:
                return convert(text if '_' not in text else 'text')
            except ValueError:
                pass
        return {'': None, '.inf': inf, '-.inf': -inf, '.nan': nan}.get(text.lower(), text)


_Loader.add_constructor('tag:yaml.org,2002:map', _Loader.pairs)
_Loader.add_constructor('tag:yaml.org,2002:str', _Loader.scalar)


def read_robots(path: Path, instead: Mapping[str, Any] | None = None, namespace: str = '',
                ) -> list[RobotSettings]:
    """
    Return the settings of all robots in a parameter file; each of several tips is one.

    Parameters given instead take precedence; the namespace is the node's.
    """
    values = {setting.name: setting.default for setting in NODE}
    given = _parameters(path, '/'.join(['', *filter(None, namespace.split('/')), NODE_NAME]))
    values.update({key: given[key] for key in values if key in given})
    node = NodeSettings.read(values)
    if not node.robots:
        raise ToolError(f"{path}: parameter 'robots' names no robot")
    known = set(values) | {f'{robot}.{s.name}' for robot in node.robots for s in ROBOT}
    known |= {f'{robot}.{tip}.{s.name}' for robot in node.robots
              for tip in given.get(f'{robot}.tips', ()) for s in OF_TIP}
    for name, value in given.items():
        if name not in known and not OF_ROS.fullmatch(name):
            similar = most_like(name, known)
            raise ParameterError(name, value, repr(similar) if similar else
                                 'parameters of the node and of its robots')
    return [part for robot in node.robots for part in robot_settings(robot, {**{
        key.removeprefix(f'{robot}.'): value for key, value in given.items()
        if key.startswith(f'{robot}.')}, **(instead or {})}).parts]


def robot_settings(name: str, values: Mapping[str, Any]) -> RobotSettings:
    """Return the settings of a robot from some of its parameters; defaults for the rest."""
    return RobotSettings.read(name, {**{s.name: s.default for s in ROBOT}, **values})


def matches(pattern: str, node: str) -> bool:
    """
    Return whether parameters under a pattern in a file are those of a node with a full name.

    As in ROS ``*`` stands for one part of a name, ``**`` for any number of them.

    Examples
    --------
    >>> [matches(p, '/cell/arm') for p in ('/cell/arm', 'cell/*', '/**', '/**/arm', 'arm')]
    [True, True, True, True, False]

    """
    parts = [part for part in pattern.split('/') if part]
    expression = ''.join('(/[^/]+)*' if part == '**' else '/[^/]+' if part == '*'
                         else '/' + re.escape(part) for part in parts)
    return re.fullmatch(expression, node) is not None


def _parameters(path: Path, node: str) -> dict[str, Any]:
    """Return the parameters of the node by their full names; what is last in the file wins."""
    try:
        content = yaml.load(path.read_text(), Loader=_Loader)
    except OSError as error:
        raise ToolError(f'{path}: {error.strerror}') from None
    except (ValueError, yaml.YAMLError) as error:
        raise ToolError(f'{path}: {" ".join(str(error).split())}') from None
    flat: dict[str, Any] = {}
    there = list(_nodes(content))
    for pattern, parameters in there:
        if matches(pattern, node):
            flat.update(_flat(parameters))
    if not flat:
        seen = ', '.join(pattern for pattern, _ in there)
        raise ToolError(
            f'{path}: no parameters of the node {node}; '
            + (f'there are those of {seen}; is the namespace right?' if there
               else f'allowed: a mapping {NODE_NAME}: {PARAMETERS}: ...'))
    return flat


def _nodes(tree: Any, prefix: str = '') -> Iterator[tuple[str, Pairs]]:
    """Yield names of nodes, with wildcards and namespaces, and the parameters below them."""
    for key, value in tree if isinstance(tree, tuple) else ():
        if key == PARAMETERS and prefix and isinstance(value, tuple):
            yield prefix, value
        elif isinstance(value, tuple):
            yield from _nodes(value, f'{prefix}/{str(key).strip("/")}')


def _flat(tree: Pairs) -> dict[str, Any]:
    """Return parameters by their full names; raise ParameterError for what the node would miss."""
    out: dict[str, Any] = {}
    for name, value in _leaves(tree):
        if name in out:
            raise ParameterError(name, [out[name], value], 'once in a file')
        if value is None:
            raise ParameterError(name, None, 'a value: ROS refuses the file without one')
        if isinstance(value, list) and len({type(v) for v in value}) > 1:
            raise ParameterError(name, value, 'a list of one type, such as [0.0, 0.5]: ROS '
                                 'refuses the file else')
        out[name] = value
    return out


def _leaves(tree: Pairs, prefix: str = '') -> Iterator[tuple[str, Any]]:
    for key, value in tree:
        if isinstance(value, tuple):
            yield from _leaves(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value

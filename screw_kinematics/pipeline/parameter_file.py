# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node's parameter file, read without ROS: the same robots, settings and checks."""
from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
import re
from typing import Any

import yaml

from .settings import NODE, NodeSettings, OF_TIP, ROBOT, RobotSettings
from ..errors import ParameterError, ToolError

NODE_NAME = 'kinematic_state_publisher'
PARAMETERS = 'ros__parameters'
OF_ROS = re.compile(r'use_sim_time|start_type_description_service|qos_overrides\..+')
"""Parameters that every node of ROS has."""


def read_robots(path: Path, instead: Mapping[str, Any] | None = None, namespace: str = '',
                ) -> list[RobotSettings]:
    """
    Return the settings of all robots in a parameter file; each of several tips is one.

    Parameters
    ----------
    path : path
        YAML as ``--params-file`` takes it.
    instead : mapping of str to value, optional
        Parameters of robots that take precedence.
    namespace : str
        Of the node.

    Raises
    ------
    ToolError
        The file is not readable, or has no parameters of the node.
    ParameterError
        A parameter does not exist or has a wrong value.

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
            similar = get_close_matches(name, known, 1, 0.5)
            raise ParameterError(name, value, f'{similar[0]!r}' if similar else
                                 'parameters of the node and of its robots')
    return [part for robot in node.robots for part in robot_settings(robot, {**{
        key.removeprefix(f'{robot}.'): value for key, value in given.items()
        if key.startswith(f'{robot}.')}, **(instead or {})}).parts]


def robot_settings(name: str, values: Mapping[str, Any]) -> RobotSettings:
    """Return the settings of a robot from some of its parameters; defaults for the rest."""
    return RobotSettings.read(name, {**{s.name: s.default for s in ROBOT}, **values})


def matches(pattern: str, node: str) -> bool:
    """
    Return whether parameters under a name in a file are those of a node.

    Parameters
    ----------
    pattern : str
        As ROS has it: ``*`` stands for one part of a name, ``**`` for any number of them.
    node : str
        Its full name.

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
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
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


def _nodes(tree: Any, prefix: str = '') -> Iterator[tuple[str, Mapping[Any, Any]]]:
    """Yield names of nodes, with wildcards and namespaces, and the parameters below them."""
    for key, value in tree.items() if isinstance(tree, dict) else ():
        if key == PARAMETERS and prefix and isinstance(value, dict):
            yield prefix, value
        elif isinstance(value, dict):
            yield from _nodes(value, f'{prefix}/{str(key).strip("/")}')


def _flat(tree: Mapping[Any, Any], prefix: str = '') -> dict[str, Any]:
    out: dict[str, Any] = {}
    for key, value in tree.items():
        if isinstance(value, dict):
            out.update(_flat(value, f'{prefix}{key}.'))
        else:
            out[f'{prefix}{key}'] = value
    return out

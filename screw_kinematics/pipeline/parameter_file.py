# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node's parameter file, read without ROS: the same robots, settings and checks."""
from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from .settings import NODE, NodeSettings, ROBOT, RobotSettings
from ..errors import ParameterError, ToolError

NODE_NAMES = ('kinematic_state_publisher', '/kinematic_state_publisher', '/**')


def read_robots(path: Path, instead: Mapping[str, Any] | None = None) -> list[RobotSettings]:
    """
    Return the settings of all robots in a parameter file.

    Parameters
    ----------
    path : path
        YAML as ``--params-file`` takes it.
    instead : mapping of str to value, optional
        Parameters of robots that take precedence.

    Raises
    ------
    ToolError
        The file is not readable, or has no parameters of the node.
    ParameterError
        A parameter does not exist or has a wrong value.

    """
    values = {setting.name: setting.default for setting in NODE}
    given = _parameters(path)
    values.update({key: given[key] for key in values if key in given})
    node = NodeSettings.read(values)
    if not node.robots:
        raise ToolError(f"{path}: parameter 'robots' names no robot")
    known = set(values) | {f'{robot}.{s.name}' for robot in node.robots for s in ROBOT}
    for name, value in given.items():
        if name not in known and not name.startswith('qos_overrides.'):
            similar = get_close_matches(name, known, 1, 0.5)
            raise ParameterError(name, value, f'{similar[0]!r}' if similar else
                                 'parameters of the node and of its robots')
    return [robot_settings(robot, {**{
        key.removeprefix(f'{robot}.'): value for key, value in given.items()
        if key.startswith(f'{robot}.')}, **(instead or {})}) for robot in node.robots]


def robot_settings(name: str, values: Mapping[str, Any]) -> RobotSettings:
    """Return the settings of a robot from some of its parameters; defaults for the rest."""
    return RobotSettings.read(name, {**{s.name: s.default for s in ROBOT}, **values})


def _parameters(path: Path) -> dict[str, Any]:
    """Return the parameters of the node by their full names."""
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ToolError(f'{path}: {" ".join(str(error).split())}') from None
    flat: dict[str, Any] = {}
    if isinstance(content, dict):
        for name in reversed(NODE_NAMES):    # the node's own name wins
            node = content.get(name)
            if isinstance(node, dict) and isinstance(node.get('ros__parameters'), dict):
                flat.update(_flat(node['ros__parameters']))
    if not flat:
        raise ToolError(f'{path}: no parameters of {NODE_NAMES[0]!r}; allowed: a mapping '
                        f'{NODE_NAMES[0]}: ros__parameters: ...')
    return flat


def _flat(tree: Mapping[Any, Any], prefix: str = '') -> dict[str, Any]:
    out: dict[str, Any] = {}
    for key, value in tree.items():
        if isinstance(value, dict):
            out.update(_flat(value, f'{prefix}{key}.'))
        else:
            out[f'{prefix}{key}'] = value
    return out

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of the node: declared, read, checked as a whole before they change."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..errors import ParameterError
from ..pipeline.setting import most_like, one_of, Setting, tip_frames, whole_number
from ..pipeline.settings import NODE, NodeSettings, OF_TIP, ROBOT, RobotSettings

QOS = 'qos_overrides.'

QOS_POLICIES: dict[str, tuple[str, Any]] = {
    'history': ('keep_last, keep_all or system_default',
                one_of('keep_last', 'keep_all', 'system_default')),
    'reliability': ('reliable, best_effort or system_default',
                    one_of('reliable', 'best_effort', 'system_default')),
    'depth': ('a whole number from 1 to 1000000', whole_number(1, 1_000_000))}
"""What standard parameters of topics may be: in words, and a check."""

_FIXED = {
    '': 'May change at any time.',
    'configured': 'May change only while the node is unconfigured.',
    'started': 'Set at start only.',
}


class NodeParameters:
    """
    The parameters of one node, declared on it.

    ``given`` are the names of those that the user gave; by default all that the node was given,
    which are otherwise those of a node before it.
    """

    def __init__(self, node: Node, given: frozenset[str] | None = None) -> None:
        self._node = node
        self.given = frozenset(self._overrides()) if given is None else given
        self._declared: dict[str, Setting] = {}
        for setting in NODE:
            self._declare('', setting)

    def node_settings(self) -> NodeSettings:
        """Return the settings of the node; raise ParameterError if a value is not allowed."""
        return NodeSettings.read(self._values('', NODE, {}))

    def robot_settings(self, robot: str, changes: Mapping[str, Any] | None = None,
                       ) -> RobotSettings:
        """
        Return the settings of one robot, as they would be with some changes.

        Raise ParameterError if a value is not allowed, alone or with the others.
        """
        changes = changes or {}
        values = self._values(f'{robot}.', ROBOT, changes)
        for tip in self._tips(robot):
            own = self._values(f'{robot}.{tip}.', OF_TIP, changes)
            values |= {f'{tip}.{name}': value for name, value in own.items()}
        return RobotSettings.read(robot, values)

    def declare_robot(self, robot: str) -> None:
        """Declare the parameters of a robot, unless they are."""
        for setting in ROBOT:
            if f'{robot}.{setting.name}' not in self._declared:
                self._declare(f'{robot}.', setting)
        for tip in self._tips(robot):
            for setting in OF_TIP:
                if f'{robot}.{tip}.{setting.name}' not in self._declared:
                    of_robot = self._node.get_parameter(f'{robot}.{setting.name}').value
                    self._declare(f'{robot}.{tip}.', replace(setting, default=of_robot))

    def check_qos_overrides(self) -> None:
        """Raise ParameterError if a standard parameter of a topic has a wrong value."""
        for name, parameter in self._overrides().items():
            words, check = QOS_POLICIES.get(name.rpartition('.')[2], ('', None))
            if name.startswith(QOS) and check is not None:
                try:
                    check(parameter.value)
                except ValueError:
                    raise ParameterError(name, parameter.value, words) from None

    def check_changeable(self, changes: Mapping[str, Any], configured: bool) -> None:
        """Raise ParameterError if one of the parameters cannot become this in this state."""
        for name, value in changes.items():
            setting = self._declared.get(name)
            if setting is None or not setting.fixed:
                continue
            present = self._node.get_parameter(name).value
            if value == present:        # as of a dump that is loaded again
                continue
            if setting.fixed == 'started':
                raise ParameterError(name, value, f'{present!r} until the node is started again')
            if configured:
                raise ParameterError(name, value, f'{present!r} until the node is unconfigured '
                                     '(lifecycle: deactivate, cleanup)')

    def check_value(self, name: str, value: Any) -> None:
        """Raise ParameterError if the value alone is not allowed."""
        setting = self._declared.get(name)
        if setting is not None:
            setting.read(value, name.removesuffix(setting.name))

    def unknown(self, awaited: Iterable[str] = ()) -> list[str]:
        """
        Return a sentence for each given parameter that does not exist.

        The standard parameters of awaited topics do not exist yet.
        """
        later = tuple(f'{QOS}{topic}.' for topic in awaited)
        topics = [f'{QOS}{name}' for name in self._node.get_parameters_by_prefix(QOS[:-1])]
        sentences = []
        for name in sorted(self.given):
            if not self._node.has_parameter(name) and not name.startswith(later):
                known = topics if name.startswith(QOS) else self._declared
                sentences.append(no_such_parameter(name, known))
        return sentences

    def _tips(self, robot: str) -> tuple[str, ...]:
        """Return the tips of a robot; none if the parameter is wrong, which is told elsewhere."""
        try:
            return tip_frames(self._node.get_parameter(f'{robot}.tips').value)
        except ValueError:
            return ()

    def _overrides(self) -> Mapping[str, Parameter]:
        """Return what was given by file or argument; rclpy ignores what is never declared."""
        return getattr(self._node, '_parameter_overrides', {})

    def _values(self, prefix: str, settings: Iterable[Setting], changes: Mapping[str, Any],
                ) -> dict[str, Any]:
        return {
            s.name: changes[prefix + s.name] if prefix + s.name in changes
            else self._node.get_parameter(prefix + s.name).value
            for s in settings}

    def _declare(self, prefix: str, setting: Setting) -> None:
        descriptor = ParameterDescriptor(
            description=setting.text,
            additional_constraints=f'Allowed: {setting.allowed}. {_FIXED[setting.fixed]}',
            # So that 0 is taken for 0.0, and a wrong type is reported as all wrong values are.
            dynamic_typing=True)
        name = prefix + setting.name
        self._node.declare_parameter(name, setting.default, descriptor)
        self._declared[name] = setting
        # Only now: a wrong value that was given must not fail here, with another message, but
        # where all values are read, and stay visible until it is set right.
        if setting.span is not None:
            low, high = setting.span
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=low, to_value=high)]


def as_values(parameters: Iterable[Parameter]) -> dict[str, Any]:
    """Return the values of ROS parameters by name."""
    return {p.name: p.value for p in parameters}


def no_such_parameter(name: str, known: Iterable[str]) -> str:
    """Return a sentence that says so, with the known name that is most like it."""
    known = list(known)
    of_topic = [k for k in known if name.startswith(QOS) and _topic(k) == _topic(name)]
    similar = most_like(name, known)
    hint = (f'; of this topic: {", ".join(sorted(of_topic))}' if of_topic
            else f'; did you mean {similar!r}?' if similar else '')
    return f'parameter {name!r} does not exist{hint}'


def _topic(name: str) -> str:
    """Return the topic of a standard parameter, such as qos_overrides./topic.publisher.depth."""
    return name.removeprefix(QOS).rpartition('.')[0].rpartition('.')[0]

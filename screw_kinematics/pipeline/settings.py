# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What can be set: each parameter's default, meaning, and allowed values."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from . import checks
from .group_motion import MotionSettings, VELOCITY_SOURCES
from ..errors import InvalidValueError, ParameterError
from ..motion import ESTIMATORS

OUTPUTS = ('pose', 'twist', 'accel', 'reduced_accel', 'jerk', 'snap', 'velocity',
           'twist_with_covariance', 'accel_with_covariance', 'markers',
           'passive_joint_states')

EXECUTORS = ('events', 'single_threaded')
"""Choices: ROS's events executor where it exists, or its default one."""


@dataclass(frozen=True)
class Setting:
    """
    One parameter.

    Parameters
    ----------
    name : str
    default : bool, float, str, list
    text : str
        What it does, with its unit.
    allowed : str
        The allowed values in words.
    check : callable
        Returns the value in the form used here, or raises ValueError.
    fixed : {'', 'configured', 'started'}
        From when on it cannot be changed: never, once the node is configured, or at all.
    span : (float, float), optional
        Least and greatest value of a number.

    """

    name: str
    default: Any
    text: str
    allowed: str
    check: checks.Check
    fixed: str = ''
    span: tuple[float, float] | None = None

    def read(self, value: Any, prefix: str = '') -> Any:
        """Return the checked value; raise ParameterError naming it and what is allowed."""
        try:
            return self.check(value)
        except ValueError:
            raise ParameterError(prefix + self.name, value, self.allowed) from None


def _choice(name: str, default: str, text: str, choices: tuple[str, ...]) -> Setting:
    return Setting(name, default, text, f'one of {", ".join(choices)}', checks.one_of(*choices))


def _quantity(name: str, default: float, text: str, low: float, high: float) -> Setting:
    return Setting(name, default, text, f'a number from {low:g} to {high:g}',
                   checks.number(low, high), span=(low, high))


NODE = (
    Setting('robots', [''], 'Names of the robots; the parameters of each begin with its name.',
            'different names of letters, digits and underscores, beginning with a letter, as a '
            'list such as [arm]',
            checks.robot_names, 'configured'),
    _quantity('diagnostics_rate', 1.0, 'Rate of the messages on /diagnostics [Hz]; 0: none.',
              0.0, 100.0),
    Setting('autostart', True,
            'Configure and activate at once; false: a lifecycle manager does it.',
            'true or false', checks.boolean, 'started'),
    Setting('executor', 'events',
            "ROS's events executor where it exists, or its default, single-threaded one.",
            f'one of {", ".join(EXECUTORS)}', checks.one_of(*EXECUTORS), 'started'),
    Setting('allow_remote_parameters', True,
            'Offer the parameter services; false: parameters come from files and arguments only.',
            'true or false', checks.boolean, 'started'),
)

ROBOT = (
    Setting('description', '',
            'Where the model is: package:// or file:// URI, path (.yaml, .urdf, .xacro), or URDF '
            'text itself; empty: taken from description_topic.',
            'a string', checks.text, 'configured'),
    Setting('description_topic', 'robot_description',
            'Topic of the URDF (std_msgs/String, transient local), used if description is empty.',
            'a topic name', checks.nonempty, 'configured'),
    Setting('base_frame', '', 'Frame the motion is relative to; empty: root link of the model.',
            'a frame of the model', checks.text),
    Setting('tip_frame', '',
            'Frame whose motion is published; empty: the only end of the model.',
            'a frame of the model', checks.text),
    Setting('tool_offset', [0.0] * 6,
            'Pose of the tool in the tip frame: x y z [m], roll pitch yaw [rad].',
            f'six finite numbers of at most {checks.LARGEST_OFFSET:g}', checks.offset),
    Setting('frame_prefix', '', 'Put before the frame names in messages.',
            'a string', checks.text),
    Setting('joint_states_topic', 'joint_states',
            'Topic of the joint samples, or a list of topics if the joints come on several.',
            'a topic name or a list of them', checks.topics, 'configured'),
    Setting('outputs', ['twist', 'accel'], 'What is published, each on <robot>/<output>.',
            f'a list of {", ".join(OUTPUTS)}', checks.some_of(*OUTPUTS)),
    _choice('expressed_in', 'base', 'Axes of the published vectors, and their frame_id.',
            ('base', 'tip')),
    _choice('reference_point', 'tip',
            'Point of the end effector the linear parts refer to: origin of the tip frame, or '
            'the material point now at the origin of the base frame.', ('tip', 'base')),
    _choice('velocity_source', 'auto',
            'Joint velocity: measured (as received), estimated (from positions alone), or auto '
            '(estimated, with the measured one as far as it proves right).', VELOCITY_SOURCES),
    _quantity('stale_timeout', 0.5,
              'Joints not heard of for this long are missing, and outputs stop [s].',
              0.01, 3600.0),
    _quantity('markers_rate', 20.0, 'Highest rate of the markers [Hz].', 0.1, 1000.0),
    _choice('estimator.kind', 'bank', 'How rates are estimated; bank tunes itself.',
            tuple(ESTIMATORS)),
    _quantity('estimator.delay', 0.0,
              'Outputs describe, and are stamped with, the instant this long before the latest '
              'sample [s]; 0.02 makes accelerations several times as accurate.', 0.0, 1.0),
    _quantity('estimator.max_gap', 0.25,
              'A longer pause between samples starts the estimation anew [s].', 0.001, 60.0),
    _quantity('estimator.max_velocity', 20.0,
              'A joint that seems to move faster is refused as implausible [rad/s or m/s].',
              1e-3, 1e6),
)


@dataclass(frozen=True)
class NodeSettings:
    """The settings of the node, checked; see :data:`NODE` for their meaning."""

    robots: tuple[str, ...]
    diagnostics_rate: float
    autostart: bool
    executor: str
    allow_remote_parameters: bool

    @classmethod
    def read(cls, values: Mapping[str, Any]) -> NodeSettings:
        """Return the settings from parameter values by name; raise ParameterError."""
        return cls(**{s.name: s.read(values[s.name]) for s in NODE})


@dataclass(frozen=True)
class RobotSettings:
    """The settings of one robot, checked; see :data:`ROBOT` for their meaning."""

    name: str
    description: str
    description_topic: str
    base_frame: str
    tip_frame: str
    tool_offset: tuple[float, ...]
    frame_prefix: str
    joint_states_topic: tuple[str, ...]
    outputs: tuple[str, ...]
    expressed_in: str
    reference_point: str
    stale_timeout: float
    markers_rate: float
    motion: MotionSettings

    @classmethod
    def read(cls, name: str, values: Mapping[str, Any]) -> RobotSettings:
        """
        Return the settings from parameter values by name, without the robot's name.

        Raises
        ------
        ParameterError
            A value is not allowed, alone or with the others.

        """
        prefix = f'{name}.'
        checked = {s.name: s.read(values[s.name], prefix) for s in ROBOT}
        estimator = {key.removeprefix('estimator.'): checked.pop(key)
                     for key in list(checked) if key.startswith('estimator.')}
        source = checked.pop('velocity_source')
        kind, delay = estimator.pop('kind'), estimator.pop('delay')
        if source == 'measured' and delay > 0:
            raise ParameterError(
                f'{prefix}estimator.delay', delay,
                "0, as velocity_source 'measured' has no velocity of an earlier instant")
        motion = MotionSettings(source, kind, delay, estimator)
        try:
            motion.make_estimator([False])
        except InvalidValueError as error:
            raise InvalidValueError(f"parameters '{prefix}estimator.*': {error}") from None
        return cls(name=name, **checked, motion=motion)

    @property
    def has_tool(self) -> bool:
        """Whether a tool is mounted on the tip frame."""
        return any(self.tool_offset)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What can be set: each parameter's default, meaning, and allowed values.

``expressed_in`` and ``reference_point`` of the node are the ``axes`` and ``pole`` of the library.
"""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from .outputs import OUTPUTS
from .payload import is_inertia, Payload
from .setting import (
    boolean, choice, nonempty, numbers, one_of, quantity, robot_names, Setting, some_of,
    text, tip_frames, topic_name, topics)
from ..errors import ParameterError
from ..motion import ESTIMATORS

EXECUTORS = ('events', 'single_threaded')
"""Choices: ROS's events executor where it exists, or its default one."""

VELOCITY_SOURCES = ('auto', 'measured', 'estimated')

MAX_VELOCITY = 20.0
"""Faster than this joints seem to move by errors only, unless parameters say so [rad/s, m/s]."""

LONGEST_DELAYS = {'savitzky_golay': 0.14, 'finite_difference': 0.0}
"""Of those estimators that have less than the others, since they look back no further [s]."""

LARGEST_OFFSET = 1e6
"""Of a tool from the tip frame [m, rad]."""

WITH_POINT = 'all written with a point (0.0): ROS takes a mixed list for text'


def inertia(value: Any) -> tuple[float, ...]:
    """Return the six numbers of a body's inertia, or raise ValueError."""
    six = numbers(6, 1e6)(value)
    if not is_inertia(six):
        raise ValueError
    return tuple(six)


NODE = (
    Setting('robots', [''], 'Names of the robots; the parameters of each begin with its name.',
            'different names of letters, digits and underscores, beginning with a letter, as a '
            'list such as [arm]',
            robot_names, 'configured'),
    quantity('diagnostics_rate', 1.0, 'Rate of the messages on /diagnostics [Hz]; 0: none.',
             0.0, 100.0),
    Setting('autostart', True,
            'Configure and activate at once; false: a lifecycle manager does it.',
            'true or false', boolean, 'started'),
    choice('executor', 'events',
           "ROS's events executor where it exists, or its default, single-threaded one.",
           EXECUTORS, 'started'),
    Setting('allow_remote_parameters', True,
            'Offer the parameter services; false: parameters come from files and arguments only.',
            'true or false', boolean, 'started'),
)

ROBOT = (
    Setting('description', '',
            'Where the model is: package:// or file:// URI, path (.yaml, .urdf, .xacro), or URDF '
            'text itself; empty: taken from description_topic.',
            'a string', text, 'configured'),
    Setting('description_topic', 'robot_description',
            'Topic of the URDF (std_msgs/String, transient local), used if description is empty.',
            'a topic name', nonempty, 'configured'),
    Setting('base_frame', '', 'Frame the motion is relative to; empty: root link of the model.',
            'a frame of the model', text),
    Setting('tip_frame', '',
            'Frame whose motion is published; empty: the only end of the model.',
            'a frame of the model', text),
    Setting('tips', [''],
            'Frames whose motion is published, each on <robot>/<tip>/<output>, from one '
            'estimator; empty: tip_frame, on <robot>/<output>. <robot>.<tip>.outputs, '
            '.tool_offset, .expressed_in, .reference_point, .relative_to, .wrench_* and '
            '.payload.* are those of one tip.',
            'a list of different frames of the model, without a point in their names',
            tip_frames, 'configured'),
    Setting('tool_offset', [0.0] * 6,
            'Pose of the tool in the tip frame: x y z [m], roll pitch yaw [rad].',
            f'six finite numbers of at most {LARGEST_OFFSET:g}, {WITH_POINT}',
            numbers(6, LARGEST_OFFSET)),
    Setting('frame_prefix', '', 'Put before the frame names in messages.',
            'a string', text),
    Setting('joint_states_topic', 'joint_states',
            'Topic of the joint samples, or a list of topics if the joints come on several.',
            'a topic name or a list of them', topics, 'configured'),
    Setting('base_motion_topic', '',
            'Topic of the motion of a base that drives: nav_msgs/Odometry, whose twist is in its '
            'child frame, or geometry_msgs/TwistStamped, in the axes of its frame; either frame '
            'is base_frame or fixed to it. Empty: the base stands.',
            'a topic name, or nothing', text, 'configured'),
    Setting('relative_to', '',
            'What the motion is relative to: base, or world, which is the frame of the odometry '
            'and takes the place of the base frame in all that is said of it. Empty: world if '
            'there is a base_motion_topic.', 'base, world, or nothing',
            one_of('', 'base', 'world')),
    Setting('outputs', ['twist', 'accel'], 'What is published, each on <robot>/<output>.',
            f'a list of {", ".join(OUTPUTS)}', some_of(*OUTPUTS)),
    choice('expressed_in', 'base', 'Axes of the published vectors, and their frame_id.',
           ('base', 'tip')),
    choice('reference_point', 'tip',
           'Point of the end effector the linear parts refer to: origin of the tip frame, or '
           'the material point now at the origin of the base frame.', ('tip', 'base')),
    Setting('gravity', [0.0, 0.0, -9.80665],
            'Acceleration of free fall in the axes of the base frame, for imu and '
            'compensated_wrench [m/s^2].',
            f'three finite numbers of at most 1000, {WITH_POINT}', numbers(3, 1000.0)),
    choice('velocity_source', 'auto',
           'Joint velocity: measured (as received), estimated (from positions alone), or auto '
           '(estimated, with the measured one as far as it proves right).', VELOCITY_SOURCES),
    Setting('wrench_topic', '',
            'Topic of a force sensor (geometry_msgs/WrenchStamped), for compensated_wrench.',
            'a topic name', text, 'configured'),
    Setting('wrench_frame', '',
            'Link that the force sensor is fixed to, in whose axes and about whose origin it '
            'measures; empty: frame_id of its messages.',
            'a link that is fixed to the tip frame', text),
    choice('wrench_by', 'load',
           'Who exerts the measured wrench: the load on the sensor (at rest it is the weight), or '
           'the sensor on the load (at rest it is what holds the weight).', ('load', 'sensor')),
    Setting('wrench_bias', [0.0] * 6,
            'What the sensor shows of no load: force x y z [N], torque x y z [N m].',
            f'six finite numbers of at most 1e6, {WITH_POINT}', numbers(6, 1e6)),
    quantity('payload.mass', 0.0, 'Mass of what the force sensor carries [kg].', 0.0, 1e6),
    Setting('payload.center', [0.0] * 3,
            "Its centre of mass in the frame of the sensor's link: x y z [m].",
            f'three finite numbers of at most 1000, {WITH_POINT}', numbers(3, 1000.0)),
    Setting('payload.inertia', [0.0] * 6,
            "Its inertia about its centre of mass in the axes of the sensor's link: ixx ixy ixz "
            'iyy iyz izz [kg m^2].',
            'six finite numbers, the inertia of a body: no principal moment is negative, or '
            f'larger than the two others together; {WITH_POINT}', inertia),
    quantity('stamp_offset', 0.0,
             'Added to the stamps of joint states before all else: their clock against that of '
             'other sensors, as check delay finds it [s].', -10.0, 10.0),
    quantity('stale_timeout', 0.5,
             'Joints not heard of for this long are missing, and outputs stop [s].',
             0.01, 3600.0),
    quantity('markers_rate', 20.0, 'Highest rate of the markers [Hz].', 0.1, 1000.0),
    quantity('markers_deviations', 0.0,
             'Markers show how uncertain velocities and accelerations are by ellipsoids at the '
             'heads of their arrows, so many standard deviations large; 0: none.', 0.0, 100.0),
    choice('estimator.kind', 'bank', 'How rates are estimated; bank tunes itself.',
           tuple(ESTIMATORS)),
    quantity('estimator.delay', 0.0,
             'Outputs describe, and are stamped with, the instant this long before the latest '
             'sample [s]; 0.02 makes accelerations several times as accurate.', 0.0, 1.0),
    quantity('estimator.max_gap', 0.25,
             'A longer pause between samples starts the estimation anew [s].', 0.001, 60.0),
    quantity('estimator.max_velocity', MAX_VELOCITY,
             'A joint that seems to move faster, or 1.5 times as fast as its description allows, '
             'is refused as implausible [rad/s or m/s].', 1e-3, 1e6),
)


OF_TIP = tuple(setting for setting in ROBOT if setting.name in (
    'outputs', 'tool_offset', 'expressed_in', 'reference_point', 'relative_to')
    or setting.name.startswith(('wrench_', 'payload.')))
"""What each of several tips may have of its own."""


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
class MotionSettings:
    """
    How joint motion is obtained from samples.

    The velocity source is 'auto': the estimator weighs the measured velocity as far as it earns
    trust; 'measured': position and velocity are the measured ones, accelerations are estimated; or
    'estimated': the measured velocity is ignored. The motion describes the instant this delay
    before the latest sample [s], whose stamp is that of the message plus an offset [s]. Options
    are further ones of the estimator.
    """

    velocity_source: str = 'auto'
    estimator: str = 'bank'
    delay: float = 0.0
    stamp_offset: float = 0.0
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def stamp_offset_ns(self) -> int:
        """Return what is added to the samples' stamps [ns]."""
        return round(self.stamp_offset * 1e9)

    @property
    def max_velocity(self) -> float:
        """How fast a joint may seem to move, whatever its description says [rad/s, m/s]."""
        return float(self.options.get('max_velocity', MAX_VELOCITY))


@dataclass(frozen=True)
class RobotSettings:
    """The settings of one robot, checked; see :data:`ROBOT` for their meaning."""

    name: str
    description: str
    description_topic: str
    base_frame: str
    tip_frame: str
    tips: tuple[str, ...]
    tool_offset: tuple[float, ...]
    frame_prefix: str
    joint_states_topic: tuple[str, ...]
    base_motion_topic: str
    relative_to: str
    outputs: tuple[str, ...]
    expressed_in: str
    reference_point: str
    gravity: tuple[float, ...]
    wrench_topic: str
    wrench_frame: str
    wrench_by: str
    wrench_bias: tuple[float, ...]
    payload: Payload
    stale_timeout: float
    markers_rate: float
    markers_deviations: float
    motion: MotionSettings
    of_tips: tuple[RobotSettings, ...] = ()

    @classmethod
    def read(cls, name: str, values: Mapping[str, Any]) -> RobotSettings:
        """
        Return the settings from parameter values by name, without the robot's name.

        Those of a tip, such as ``tool0.outputs``, may be among them.
        """
        prefix = f'{name}.'
        checked = {s.name: s.read(values[s.name], prefix) for s in ROBOT}
        checked['payload'] = Payload(**_taken(checked, 'payload.'))
        estimator = _taken(checked, 'estimator.')
        checked['base_motion_topic'] = checked['base_motion_topic'].strip()
        checked['relative_to'] = _relative_to(
            checked['base_motion_topic'], checked['relative_to'], prefix)
        source, offset = checked.pop('velocity_source'), checked.pop('stamp_offset')
        kind, delay = estimator.pop('kind'), estimator.pop('delay')
        if source == 'measured' and delay > 0:
            raise ParameterError(
                f'{prefix}estimator.delay', delay,
                "0, as velocity_source 'measured' has no velocity of an earlier instant")
        longest = LONGEST_DELAYS.get(kind, delay)
        if delay > longest:
            raise ParameterError(f'{prefix}estimator.delay', delay,
                                 f'at most {longest:g} with estimator.kind {kind!r}')
        settings = cls(name=name, **checked,
                       motion=MotionSettings(source, kind, delay, offset, estimator))
        settings = replace(settings, of_tips=tuple(
            settings._of_tip(tip, values) for tip in settings.tips))
        for part in settings.parts:
            if 'compensated_wrench' in part.outputs and not part.wrench_topic:
                raise ParameterError(
                    f'{part.name}.wrench_topic', '',
                    'the topic of a force sensor, as compensated_wrench is one of the outputs')
        return settings

    def _of_tip(self, tip: str, values: Mapping[str, Any]) -> RobotSettings:
        """Return the settings of one tip: what it has not of its own is the robot's."""
        prefix = f'{self.name}.{tip}.'
        own = {s.name: s.read(values.get(f'{tip}.{s.name}', values[s.name]), prefix)
               for s in OF_TIP}
        own['payload'] = Payload(**_taken(own, 'payload.'))
        own['relative_to'] = _relative_to(self.base_motion_topic, own['relative_to'], prefix)
        return replace(self, name=prefix[:-1], tip_frame=tip, tips=(), **own)

    @property
    def parts(self) -> tuple[RobotSettings, ...]:
        """Return the settings of each tip: of several, or of the only one."""
        return self.of_tips or (self,)

    @property
    def topic(self) -> str:
        """Return what the names of its topics begin with."""
        robot, _, tip = self.name.partition('.')
        return f'{robot}/{topic_name(tip)}' if tip else robot

    @property
    def on_moving_base(self) -> bool:
        """Whether some of its motion is relative to the world."""
        return any(part.relative_to == 'world' for part in self.parts)

    @property
    def has_tool(self) -> bool:
        """Whether a tool is mounted on the tip frame."""
        return any(self.tool_offset)


def _taken(values: dict[str, Any], prefix: str) -> dict[str, Any]:
    """Take those whose names have a prefix out of values; return them without it."""
    return {name.removeprefix(prefix): values.pop(name) for name in list(values)
            if name.startswith(prefix)}


def _relative_to(topic: str, given: str, prefix: str) -> str:
    """Return 'base' or 'world'; raise ParameterError if nothing tells how the base moves."""
    if given == 'world' and not topic:
        raise ParameterError(f'{prefix}relative_to', given, "base, as long as the robot's "
                             'base_motion_topic is empty')
    return given or ('world' if topic else 'base')

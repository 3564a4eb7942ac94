# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of one robot: who listens, and what publishes a state on each."""
from __future__ import annotations

from importlib import import_module
from typing import Any, NamedTuple, Protocol

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions

from .markers import MarkerPublisher
from ..messages.wrench import WrenchSample
from ..pipeline.compensation import Compensation, WrenchWriter
from ..pipeline.kinematics import State
from ..pipeline.message_writers import JointColumns, message_writer, MessageWriter
from ..pipeline.outputs import KINDS, OutputKind, UNCERTAIN_MARKERS
from ..pipeline.robot_model import tips_of
from ..pipeline.robot_program import Needs, RobotProgram
from ..pipeline.settings import RobotSettings
from ..pipeline.wrench_sensor import WrenchSensor


class OutputPublisher(Protocol):
    """What publishes states on one topic."""

    order: int    # highest derivative of the joint positions that it needs

    def publish(self, state: State) -> None:
        """Publish a state."""


class BytesPublisher:
    """
    Publishes messages that are written as bytes.

    By the raw door: `Publisher.publish` asks each time of what kind the message is, and keeps
    other threads from destroying the publisher meanwhile, which takes longer than to publish;
    only the thread that publishes destroys publishers here.
    """

    def __init__(self, publisher: Publisher, writer: MessageWriter, order: int) -> None:
        self.order = order
        self._handle = publisher.handle
        self._writer = writer

    def publish(self, state: State) -> None:
        """Publish a state."""
        self._handle.publish_raw(self._writer.encode(state))


class WrenchPublisher:
    """Publishes wrenches as soon as the state and the measured wrench of an instant are there."""

    def __init__(self, publisher: Publisher, compensation: Compensation, order: int) -> None:
        self.order = order
        self._handle = publisher.handle
        self._compensation = compensation

    def publish(self, state: State) -> None:
        """Publish what can be told with this state."""
        for message in self._compensation.take_state(state):
            self._handle.publish_raw(message)

    def take(self, sample: WrenchSample) -> None:
        """Publish what can be told with this wrench."""
        for message in self._compensation.take_wrench(sample):
            self._handle.publish_raw(message)


class Topic(NamedTuple):
    """An output of one tip of the robot, by the tip's number."""

    tip: int
    output: str


class Publishers:
    """The topics of one robot; their publishers are created on the node."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers: dict[Topic, Publisher] = {}
        self._active: dict[Topic, OutputPublisher] = {}
        self._without_base: dict[Topic, OutputPublisher] = {}
        self._names: dict[Topic, str] = {}
        self._kinds: dict[Topic, OutputKind] = {}
        self._tips = 1
        self.sensors: dict[int, WrenchSensor] = {}    # by the number of the tip that has one
        self.wanted: tuple[Topic, ...] = ()     # that somebody listened to when last asked

    def join(self, node: Node, settings: RobotSettings) -> None:
        """Have these topics on another node, in place of one that was destroyed."""
        self.deactivate()
        self._publishers.clear()
        self.wanted = ()
        self._node = node
        self.advertise(settings)

    def advertise(self, settings: RobotSettings) -> None:
        """Have a topic for each output of these settings, and no others."""
        self._tips = len(settings.parts)
        wanted = {Topic(k, output): f'{part.topic}/{output}'
                  for k, part in enumerate(settings.parts) for output in part.outputs}
        self.sensors = {k: self._sensor(k, part) for k, part in enumerate(settings.parts)
                        if part.wrench_topic}
        self._names = {topic: name.removeprefix(f'{settings.topic}/')
                       for topic, name in wanted.items()}
        self._kinds = {topic: UNCERTAIN_MARKERS if topic.output == 'markers'
                       and settings.parts[topic.tip].markers_deviations else KINDS[topic.output]
                       for topic in wanted}
        for topic in self._publishers.keys() - wanted.keys():
            self._active.pop(topic, None)
            self._without_base.pop(topic, None)
            self._node.destroy_publisher(self._publishers.pop(topic))
        for topic, name in wanted.items():
            if topic not in self._publishers:
                self._publishers[topic] = self._node.create_publisher(
                    message_type(KINDS[topic.output].type_name), name, QoSProfile(depth=10),
                    qos_overriding_options=QoSOverridingOptions.with_default_policies())
        self.wanted = tuple(topic for topic in self.wanted if topic in self._publishers)

    def update_demand(self) -> bool:
        """See who listens; return whether that changed."""
        order = list(KINDS)
        wanted = tuple(sorted(
            (topic for topic, publisher in self._publishers.items()
             if publisher.get_subscription_count() > 0),
            key=lambda topic: (topic.tip, order.index(topic.output))))
        changed = wanted != self.wanted
        self.wanted = wanted
        return changed

    @property
    def wanted_names(self) -> list[str]:
        """Names of the topics that somebody listens to, without the robot's."""
        return [self._names[topic] for topic in self.wanted]

    @property
    def needs(self) -> Needs:
        """Return for each tip the outputs of a program that serves what is wanted."""
        needs: list[dict[str, None]] = [{} for _ in range(self._tips)]
        for topic in self.wanted:
            # Outputs that are of the joints alone go with the smallest program.
            needs[topic.tip] |= dict.fromkeys(self._kinds[topic].needs or ('pose',))
        return tuple(map(tuple, needs))

    @property
    def order(self) -> int:
        """Return the highest derivative of the joint positions that is wanted."""
        return max((self._kinds[topic].order for topic in self.wanted), default=0)

    @property
    def covariance(self) -> bool:
        """Whether something wanted needs the variances of the joints."""
        return any(self._kinds[topic].covariance for topic in self.wanted)

    def activate(self, program: RobotProgram, model: Any, settings: RobotSettings,
                 world: str = '') -> None:
        """
        Publish all that is wanted from now on.

        The world is the frame that a moving base moves in; empty as long as it is not known.
        """
        self._active, self._without_base = {}, {}
        chains, columns = tips_of(model)
        for topic in self.wanted:
            publisher = self._publishers[topic]
            slices, chain = program.tips[topic.tip], chains[topic.tip]
            own = settings.parts[topic.tip]
            moving = own.relative_to == 'world'
            reference = world if moving else ''
            joints = JointColumns(columns[topic.tip], len(model.joint_names), moving)
            if topic.output == 'markers':
                self._active[topic] = MarkerPublisher(
                    publisher.publish, slices, own,
                    reference or own.frame_prefix + chain.base_frame, joints)
            elif topic.output == 'compensated_wrench':
                sensor = self.sensors[topic.tip]
                sensor.mount(chain)
                self._active[topic] = WrenchPublisher(publisher, Compensation(
                    WrenchWriter(slices, own, sensor), sensor, own.stale_timeout),
                    KINDS[topic.output].order)
            else:
                self._active[topic] = BytesPublisher(publisher, message_writer(
                    topic.output, slices, chain, own, joints, reference),
                    KINDS[topic.output].order)
            if not moving:
                self._without_base[topic] = self._active[topic]

    @property
    def active(self) -> bool:
        """Whether something is published."""
        return bool(self._active)

    def deactivate(self) -> None:
        """Publish nothing."""
        self._active, self._without_base = {}, {}

    def publish(self, state: State) -> None:
        """Publish a state on every active topic, as far as it is known."""
        active = self._without_base if state.without_base else self._active
        for publisher in active.values():
            if publisher.order <= state.order:
                publisher.publish(state)

    def take_wrench(self, tip: int, sample: WrenchSample) -> None:
        """Take what the force sensor of a tip says, if its compensation is active."""
        publisher = self._active.get(Topic(tip, 'compensated_wrench'))
        if isinstance(publisher, WrenchPublisher):
            publisher.take(sample)

    def forget_wrenches(self) -> None:
        """Forget what the force sensors said, as after a jump of the clock."""
        for sensor in self.sensors.values():
            sensor.reset()

    def clear_markers(self) -> None:
        """Delete the markers that viewers show of this robot."""
        for publisher in self._active.values():
            if isinstance(publisher, MarkerPublisher):
                publisher.clear()

    def close(self) -> None:
        """Remove the topics."""
        self.deactivate()
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        self._publishers.clear()
        self.wanted = ()

    def _sensor(self, tip: int, settings: RobotSettings) -> WrenchSensor:
        """Return the force sensor of a tip; the one it had, if it may stay as it is."""
        before = self.sensors.get(tip)
        if before is None:
            return WrenchSensor(settings)
        return before if before.settings == settings else before.renewed(settings)


def message_type(name: str) -> Any:
    """Return the ROS message type of a name such as ``geometry_msgs/msg/TwistStamped``."""
    package, folder, kind = name.split('/')
    return getattr(import_module(f'{package}.{folder}'), kind)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics that the node listens to, and who gets what they say."""
from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from time import perf_counter
from typing import Any, Generic, TypeVar

from geometry_msgs.msg import WrenchStamped
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.validate_topic_name import validate_topic_name
from sensor_msgs.msg import JointState

from .backlog import Backlog
from .foreign_encoding import as_plain, read_by_middleware
from .publishers import message_type
from .qos import input_qos
from .robot import Robot
from ..errors import MalformedMessageError, ParameterError, Reason
from ..messages.base_motion import BaseSample, READERS
from ..messages.joint_state import JointSample, JointStateDecoder
from ..messages.wrench import read_wrench, WrenchSample

Sample = TypeVar('Sample', JointSample, WrenchSample, BaseSample)


class TopicInput(ABC, Generic[Sample]):
    """
    A topic, by its full name, that is listened to for some robots while its input is open.

    Messages with stamp zero are taken to be of the moment they arrive, and counted.
    """

    content: str

    def __init__(self, node: Node, topic: str, robots: Sequence[Robot]) -> None:
        self.topic = topic
        self.robots = tuple(dict.fromkeys(robots))
        self.received = 0
        self.unstamped = 0      # messages with stamp zero
        # Messages that nobody got; all others were handed on.
        self.refused: Counter[Reason] = Counter()
        self.last_error = ''    # what was wrong with the latest message that was refused
        self.problem = ''       # why the topic cannot be listened to
        self.join(node)

    def join(self, node: Node) -> None:
        """Be an input, closed, of this node, in place of any that was destroyed."""
        self._node, self._clock = node, node.get_clock()
        self._open = False
        self._subscription: Any = None

    @abstractmethod
    def _wanted_type(self) -> Any:
        """Return the type to listen to now; None: there is nothing to listen to."""

    @abstractmethod
    def _read(self, data: bytes) -> Sample:
        """Return what a serialized message says; raise MalformedMessageError."""

    @abstractmethod
    def _hand_on(self, sample: Sample) -> None:
        """Give a sample, whose stamp is positive, to whom it concerns."""

    def open(self) -> None:
        """Listen from now on, as soon and as long as there is something to listen to."""
        self._open = True
        self.look()

    def close(self) -> None:
        """Listen no more."""
        self._open = False
        self.look()

    def look(self) -> bool:
        """
        See whether, and to which type, to listen; return whether that is something new.

        The middleware is not asked to report lost messages: rmw_fastrtps 8.4 takes two locks in
        one order while it reports a loss and in the other while it meets one, and so a node that
        asks stands still for good under heavy losses (ros2/rmw_fastrtps, pull request 890).
        """
        wanted = self._wanted_type() if self._open else None
        if wanted is self.type:
            return False
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
        if wanted is not None:
            self._subscription = self._node.create_subscription(
                wanted, self.topic, self.receive, input_qos(), raw=True,
                qos_overriding_options=QoSOverridingOptions.with_default_policies())
        return wanted is not None

    @property
    def type(self) -> Any:
        """Return the type that is listened to; None: it does not listen."""
        return None if self._subscription is None else self._subscription.msg_type

    @property
    def publishers(self) -> int:
        """Return how many publishers the topic has; those whose messages arrive, if it listens."""
        if self._subscription is None:
            return self._node.count_publishers(self.topic)
        count: int = self._subscription.get_publisher_count()
        return count

    def receive(self, data: bytes) -> None:
        """Take a serialized message, and hand on what it says."""
        self._take(data)

    def _take(self, data: bytes) -> None:
        self.received += 1
        try:
            sample = self._read(data)
        except MalformedMessageError as error:
            self._refuse(Reason.MALFORMED, str(error))
            return
        if sample.stamp_ns <= 0:
            stamp_ns = self._stamp(sample.stamp_ns)
            if stamp_ns is None:
                return
            sample = sample._replace(stamp_ns=stamp_ns)
        self._hand_on(sample)

    def _stamp(self, stamp_ns: int) -> int | None:
        """Return the present instead of no stamp [ns]; None if the message is refused."""
        if stamp_ns < 0:
            self._refuse(Reason.STAMP_NEGATIVE, f'a stamp of {stamp_ns * 1e-9:.3f} s')
            return None
        self.unstamped += 1
        now: int = self._clock.now().nanoseconds
        if now <= 0:
            self._refuse(Reason.NO_TIME, 'no stamp, and nothing on /clock yet')
            return None
        return now

    def _refuse(self, reason: Reason, error: str) -> None:
        self.refused[reason] += 1
        self.last_error = error


class JointInput(TopicInput[JointSample]):
    """A topic of joint states, for every robot of it."""

    content = 'joint states'

    def __init__(self, node: Node, topic: str, robots: Sequence[Robot],
                 backlog: Backlog | None = None) -> None:
        super().__init__(node, topic, robots)
        self._decoder = JointStateDecoder(read_by_middleware)
        self._backlog = Backlog() if backlog is None else backlog
        self._backlog.queues.append(self)

    def receive(self, data: bytes) -> None:
        """Take a serialized message, and those that wait; publish what they led to."""
        try:
            self._take(data)
            self._backlog.work_off(self)
        finally:
            self._backlog.publish(self)

    def take_waiting(self, most: int, end: float) -> int:
        """
        Take messages that wait, at most so many and until a time [s]; return how many.

        Takes none where what they lead to depends on how they and those of other topics follow.
        """
        subscription = self._subscription
        if (subscription is None or self.unstamped
                or not all(robot.has_one_stream for robot in self.robots)):
            return 0
        for count in range(most):
            if perf_counter() > end:
                return count
            found = subscription.handle.take_message(subscription.msg_type, True)
            if found is None:
                return count
            self._take(found[0])
        return most

    def publish(self) -> None:
        """Publish what the messages taken have led to."""
        for robot in self.robots:
            robot.publish()

    def _wanted_type(self) -> Any:
        return JointState

    def _read(self, data: bytes) -> JointSample:
        return self._decoder.decode(data)

    def _hand_on(self, sample: JointSample) -> None:
        for robot in self.robots:
            robot.take(sample)


class WrenchInput(TopicInput[WrenchSample]):
    """A topic of a force sensor, listened to while somebody wants what is made of it."""

    content = 'wrenches'

    def __init__(self, node: Node, topic: str, robots: Sequence[Robot]) -> None:
        super().__init__(node, topic, robots)
        self._tips = [(robot, k) for robot in self.robots
                      for k, part in enumerate(robot.settings.parts)
                      if part.wrench_topic
                      and node.resolve_topic_name(part.wrench_topic) == topic]

    def _wanted_type(self) -> Any:
        return WrenchStamped if any(
            robot.wants_wrench(tip) for robot, tip in self._tips) else None

    def _read(self, data: bytes) -> WrenchSample:
        return read_wrench(as_plain(data, WrenchStamped))

    def _hand_on(self, sample: WrenchSample) -> None:
        for robot, tip in self._tips:
            robot.take_wrench(tip, sample)


class BaseInput(TopicInput[BaseSample]):
    """A topic of the motion of a base, of the type that its publishers have."""

    content = 'the motion of a base'

    @property
    def kind(self) -> str:
        """Return the name of the type that is listened to; empty: none yet."""
        return '' if self.type is None else self._kind

    def _wanted_type(self) -> Any:
        if self.type is not None and self.publishers:
            return self.type
        kinds = [info.topic_type for info in self._node.get_publishers_info_by_topic(self.topic)]
        known = [kind for kind in READERS if kind in kinds]
        self.problem = '' if known or not kinds else (
            f'{self.topic} is of type {kinds[0]}; allowed: {", ".join(READERS)}')
        if not known:
            return self.type
        self._kind = known[0]
        return message_type(self._kind)

    def _read(self, data: bytes) -> BaseSample:
        return READERS[self._kind](as_plain(data, self.type))

    def _hand_on(self, sample: BaseSample) -> None:
        for robot in self.robots:
            robot.take_base(sample)


def by_topic(node: Node, robots: Iterable[Robot], parameter: str,
             topics: Callable[[Robot], Iterable[str]]) -> dict[str, list[Robot]]:
    """
    Return the robots that listen to each topic, by its full name.

    The node's namespace and remappings apply. The parameter that holds the topics is named without
    the robot; an empty topic is none.

    Raises
    ------
    ParameterError
        A topic has an invalid name.

    """
    listeners: dict[str, list[Robot]] = {}
    for robot in robots:
        for topic in filter(None, topics(robot)):
            try:
                validate_topic_name(topic)
            except InvalidTopicNameException:
                raise ParameterError(f'{robot.name}.{parameter}', topic, 'a topic name') from None
            listeners.setdefault(node.resolve_topic_name(topic), []).append(robot)
    return listeners

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One topic of joint states, and the robots that listen to it."""
from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.validate_topic_name import validate_topic_name
from sensor_msgs.msg import JointState

from .foreign_encoding import read_by_middleware
from .robot import Robot
from ..errors import MalformedMessageError, ParameterError, Reason
from ..messages.joint_state import JointStateDecoder


def joint_states_qos() -> QoSProfile:
    """
    Return the default quality of service of the input.

    Best effort and volatile as the sensor data profile, so that it matches publishers of
    either kind, but with a longer queue: a burst must not lose samples.
    """
    return QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT,
                      durability=DurabilityPolicy.VOLATILE)


class JointInput:
    """
    A topic of joint states.

    Messages with stamp zero are taken to be of the moment they arrive, and counted.

    Parameters
    ----------
    node : rclpy.node.Node
    topic : str
    robots : sequence of Robot
        Get every readable sample.

    Attributes
    ----------
    received : int
    refused : Counter of Reason
        Messages that no robot got, by reason; all others were handed to every robot.
    unstamped : int
        Messages with stamp zero.
    last_error : str
        What was wrong with the latest message that was refused.

    """

    def __init__(self, node: Node, topic: str, robots: Sequence[Robot]) -> None:
        self._node = node
        self.topic = topic
        self.received = 0
        self.unstamped = 0
        self.refused: Counter[Reason] = Counter()
        self.last_error = ''
        self.robots = tuple(robots)
        self._clock = node.get_clock()
        self._decoder = JointStateDecoder(read_by_middleware)
        self._subscription: Any = None

    def subscribe(self) -> None:
        """
        Begin to listen.

        The middleware is not asked to report lost messages: rmw_fastrtps 8.4 takes two locks in
        one order while it reports a loss and in the other while it meets one, and so a node that
        asks stands still for good under heavy losses (ros2/rmw_fastrtps, pull request 890).
        """
        if self._subscription is None:
            self._subscription = self._node.create_subscription(
                JointState, self.topic, self.receive, joint_states_qos(), raw=True,
                qos_overriding_options=QoSOverridingOptions.with_default_policies())

    @property
    def subscribed(self) -> bool:
        """Return whether it listens."""
        return self._subscription is not None

    @property
    def publishers(self) -> int:
        """Return how many publishers the topic has whose messages can arrive."""
        return 0 if self._subscription is None else self._subscription.get_publisher_count()

    def unsubscribe(self) -> None:
        """Listen no more."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def receive(self, data: bytes) -> None:
        """Take a serialized message, and hand what it says to every robot."""
        self.received += 1
        try:
            sample = self._decoder.decode(data)
        except MalformedMessageError as error:
            self._refuse(Reason.MALFORMED, str(error))
            return
        if sample.stamp_ns <= 0:
            stamp_ns = self._stamp(sample.stamp_ns)
            if stamp_ns is None:
                return
            sample = sample._replace(stamp_ns=stamp_ns)
        for robot in self.robots:
            robot.take(sample)

    def _stamp(self, stamp_ns: int) -> int | None:
        """Return the stamp of a message [ns], now if it has none; None if it is refused."""
        if stamp_ns > 0:
            return stamp_ns
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


def by_topic(node: Node, robots: Iterable[Robot], parameter: str,
             topics: Callable[[Robot], Sequence[str]]) -> dict[str, list[Robot]]:
    """
    Return the robots that listen to each topic.

    Parameters
    ----------
    node : rclpy.node.Node
        Whose namespace and remappings apply.
    robots : iterable of Robot
        The robots to ask.
    parameter : str
        Name of the parameter that holds the topics, without the robot's.
    topics : callable
        From a robot to its topics.

    Returns
    -------
    dict from str to list of Robot
        By the full name of the topic.

    Raises
    ------
    ParameterError
        A topic has an invalid name.

    """
    listeners: dict[str, list[Robot]] = {}
    for robot in robots:
        for topic in topics(robot):
            try:
                validate_topic_name(topic)
            except InvalidTopicNameException:
                raise ParameterError(f'{robot.name}.{parameter}', topic, 'a topic name') from None
            listeners.setdefault(node.resolve_topic_name(topic), []).append(robot)
    return listeners

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One topic of joint states, and the robots that listen to it."""
from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState

from .foreign_encoding import read_by_middleware
from ..errors import MalformedMessageError
from ..messages.joint_state import JointStateDecoder

MALFORMED = 'malformed_message'
NEGATIVE_STAMP = 'stamp_negative'
NO_TIME = 'no_stamp_and_no_clock_yet'

Take = Callable[[int, tuple[str, ...], Sequence[float], Sequence[float]], None]


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
    takes : sequence of callable
        Get every readable sample.

    Attributes
    ----------
    received : int
    refused : Counter
        Messages that no robot got, by reason; all others were handed to every robot.
    unstamped : int
        Messages with stamp zero.

    """

    def __init__(self, node: Node, topic: str, takes: Sequence[Take]) -> None:
        self._node = node
        self.topic = topic
        self.received = 0
        self.unstamped = 0
        self.refused: Counter[str] = Counter()
        self.last_error = ''
        self._takes = tuple(takes)
        self._now = node.get_clock().now
        self._decode = JointStateDecoder(read_by_middleware).decode
        self._subscription: Any = None

    def listen(self) -> None:
        """
        Begin to listen.

        The middleware is not asked to report lost messages: rmw_fastrtps 8.4 takes two locks in
        one order while it reports a loss and in the other while it meets one, and so a node that
        asks stands still for good under heavy losses (ros2/rmw_fastrtps, pull request 890).
        """
        if self._subscription is None:
            self._subscription = self._node.create_subscription(
                JointState, self.topic, self._take, joint_states_qos(), raw=True,
                qos_overriding_options=QoSOverridingOptions.with_default_policies())

    @property
    def publishers(self) -> int:
        """Return how many publishers the topic has whose messages can arrive."""
        return 0 if self._subscription is None else self._subscription.get_publisher_count()

    def ignore(self) -> None:
        """Listen no more."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _take(self, data: bytes) -> None:
        self.received += 1
        try:
            stamp_ns, names, position, velocity = self._decode(data)
        except MalformedMessageError as error:
            self.last_error = str(error)
            self.refused[MALFORMED] += 1
            return
        if stamp_ns <= 0:
            if stamp_ns < 0:
                self.refused[NEGATIVE_STAMP] += 1
                return
            self.unstamped += 1
            stamp_ns = self._now().nanoseconds
            if stamp_ns <= 0:
                self.refused[NO_TIME] += 1
                return
        for take in self._takes:
            take(stamp_ns, names, position, velocity)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One topic of a force sensor, and the tips of robots that it is fixed to."""
from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions

from .foreign_encoding import wrench_by_middleware
from .joint_input import joint_states_qos
from .robot import Robot
from ..errors import MalformedMessageError, Reason
from ..messages.wrench import read_wrench


class WrenchInput:
    """
    A topic of wrenches, subscribed to only while somebody listens to what is made of them.

    Messages with stamp zero are taken to be of the moment they arrive.

    Parameters
    ----------
    node : rclpy.node.Node
    topic : str
        Its full name.
    robots : sequence of Robot
        Those with a force sensor on this topic.

    Attributes
    ----------
    received : int
    refused : Counter of Reason
        Messages that no robot got, by reason.
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
        self._tips = [(robot, k) for robot in dict.fromkeys(robots)
                      for k, part in enumerate(robot.settings.parts)
                      if part.wrench_topic
                      and node.resolve_topic_name(part.wrench_topic) == topic]
        self._clock = node.get_clock()
        self._subscription: Any = None

    @property
    def publishers(self) -> int:
        """Return how many publishers the topic has."""
        return self._node.count_publishers(self.topic)

    def update_demand(self) -> None:
        """Listen as long as somebody listens to a wrench without weight and inertia."""
        wanted = any(robot.wants_wrench(tip) for robot, tip in self._tips)
        if wanted and self._subscription is None:
            self._subscription = self._node.create_subscription(
                WrenchStamped, self.topic, self.receive, joint_states_qos(), raw=True,
                qos_overriding_options=QoSOverridingOptions.with_default_policies())
        elif not wanted:
            self.unsubscribe()

    def unsubscribe(self) -> None:
        """Listen no more."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def receive(self, data: bytes) -> None:
        """Take a serialized message, and hand what it says to every tip."""
        self.received += 1
        try:
            sample = read_wrench(data, wrench_by_middleware)
        except MalformedMessageError as error:
            self._refuse(Reason.MALFORMED, str(error))
            return
        if sample.stamp_ns == 0:
            self.unstamped += 1
            now = self._clock.now().nanoseconds
            if now <= 0:
                self._refuse(Reason.NO_TIME, 'no stamp, and nothing on /clock yet')
                return
            sample = sample._replace(stamp_ns=now)
        for robot, tip in self._tips:
            robot.take_wrench(tip, sample)

    def _refuse(self, reason: Reason, error: str) -> None:
        self.refused[reason] += 1
        self.last_error = error

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One topic that tells how a base moves, and the robots that stand on it."""
from __future__ import annotations

from typing import Any

from rclpy.qos_overriding_options import QoSOverridingOptions

from .foreign_encoding import as_plain
from .joint_input import JointInput, joint_states_qos
from .publishers import message_type
from ..errors import MalformedMessageError, Reason
from ..messages.base_motion import READERS


class BaseInput(JointInput):
    """
    A topic of the motion of a base, of the type that its publishers have.

    Attributes
    ----------
    kind : str
        The type that is listened to; empty as long as nobody publishes one that can be read.
    problem : str
        What is wrong with the type that is published.

    """

    kind = ''
    problem = ''
    _wanted = False
    _type: Any = None

    def subscribe(self) -> None:
        """Begin to listen, as soon as there is a publisher."""
        self._wanted = True
        self.look()

    def unsubscribe(self) -> None:
        """Listen no more."""
        self._wanted, self.kind = False, ''
        super().unsubscribe()

    def look(self) -> bool:
        """See of which type the topic is; return whether it is listened to anew."""
        if not self._wanted or self._subscription is not None and self.publishers:
            return False
        kinds = [info.topic_type
                 for info in self._node.get_publishers_info_by_topic(self.topic)]
        known = [kind for kind in READERS if kind in kinds]
        self.problem = '' if known or not kinds else (
            f'{self.topic} is of type {kinds[0]}; allowed: {", ".join(READERS)}')
        if not known or known[0] == self.kind:
            return False
        super().unsubscribe()
        self.kind, self._type = known[0], message_type(known[0])
        self._subscription = self._node.create_subscription(
            self._type, self.topic, self.receive, joint_states_qos(), raw=True,
            qos_overriding_options=QoSOverridingOptions.with_default_policies())
        return True

    def receive(self, data: bytes) -> None:
        """Take a serialized message, and hand what it says to every robot."""
        self.received += 1
        try:
            sample = READERS[self.kind](as_plain(data, self._type))
        except MalformedMessageError as error:
            self._refuse(Reason.MALFORMED, str(error))
            return
        stamp_ns = self._stamp(sample.stamp_ns)
        if stamp_ns is not None:
            sample = sample._replace(stamp_ns=stamp_ns)
            for robot in self.robots:
                robot.take_base(sample)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint states in another encapsulation than plain little-endian CDR."""
from __future__ import annotations

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from ..errors import MalformedMessageError
from ..messages.joint_state import JointSample


def read_by_middleware(data: bytes) -> JointSample:
    """Return the sample in a serialized message, by the middleware's own deserialisation."""
    try:
        message = deserialize_message(data, JointState)
    except RuntimeError as error:
        raise MalformedMessageError('JointState', str(error).splitlines()[0]) from None
    stamp = message.header.stamp
    return JointSample(stamp.sec * 10**9 + stamp.nanosec, tuple(message.name),
                       tuple(message.position), tuple(message.velocity))

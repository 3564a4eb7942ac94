# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages in another encapsulation than plain little-endian CDR."""
from __future__ import annotations

from typing import Any

from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from ..errors import MalformedMessageError
from ..messages.joint_state import JointSample


def read_by_middleware(data: bytes) -> JointSample:
    """Return the sample in a serialized message, by the middleware's own deserialisation."""
    message = _deserialized(data, JointState)
    stamp = message.header.stamp
    return JointSample(stamp.sec * 10**9 + stamp.nanosec, tuple(message.name),
                       tuple(message.position), tuple(message.velocity))


def as_plain(data: bytes, kind: Any) -> bytes:
    """Return a serialized message of a type in plain little-endian CDR."""
    if data[:2] == b'\0\1':
        return data
    plain: bytes = serialize_message(_deserialized(data, kind))
    return plain


def _deserialized(data: bytes, kind: Any) -> Any:
    try:
        return deserialize_message(data, kind)
    except RuntimeError as error:
        raise MalformedMessageError(kind.__name__, str(error).splitlines()[0]) from None

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Decoding of `geometry_msgs/WrenchStamped` from the bytes that travel on the wire."""
from __future__ import annotations

from typing import NamedTuple

from .headed import read_headed

TYPE = 'geometry_msgs/msg/WrenchStamped'


class WrenchSample(NamedTuple):
    """The content of a message."""

    stamp_ns: int                # of the measurement [ns]
    frame_id: str                # in whose axes and about whose origin it is
    values: tuple[float, ...]    # force [N] and torque [N m], not checked for NaN


def read_wrench(data: bytes) -> WrenchSample:
    """Return what a serialized message says."""
    stamp_ns, (frame,), values = read_headed('WrenchStamped', data, 1, 6)
    return WrenchSample(stamp_ns, frame, values)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joint samples as they came: collected by the set of joints that comes together."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..errors import MalformedMessageError
from ..messages.joint_state import JointSample, JointStateDecoder
from ..screws.se3 import Array


@dataclass
class JointStream:
    """The samples of joints that come in one message."""

    names: tuple[str, ...]
    received: list[int] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    positions: list[Sequence[float]] = field(default_factory=list)
    velocities: list[Sequence[float]] = field(default_factory=list)
    wrong_length: int = 0

    def add(self, received: int, sample: JointSample) -> None:
        """Take a sample and when it was received [ns]."""
        if len(sample.position) != len(self.names):
            self.wrong_length += 1
            return
        self.received.append(received)
        self.stamps.append(sample.stamp_ns)
        self.positions.append(sample.position)
        self.velocities.append(sample.velocity)

    def __len__(self) -> int:
        return len(self.stamps)

    def times(self) -> Array:
        """Return the stamps, from the first one [s], shape (N,)."""
        stamps = np.array(self.stamps, dtype=np.int64)
        return (stamps - stamps[0]) * 1e-9

    def position(self) -> Array:
        """Return the positions [rad, m], shape (N, joints)."""
        return np.array(self.positions, dtype=float)

    def velocity(self) -> Array:
        """Return the velocities [rad/s, m/s], shape (N, joints); NaN where there is none."""
        missing = (float('nan'),) * len(self.names)
        return np.array([v if len(v) == len(self.names) else missing
                         for v in self.velocities], dtype=float)


class JointStreams:
    """All streams of a topic, and the messages that could not be read."""

    def __init__(self) -> None:
        self.streams: dict[tuple[str, ...], JointStream] = {}
        self.malformed = 0
        self.last_error = ''
        self._decode = JointStateDecoder().decode

    def add(self, received: int, data: bytes) -> None:
        """Take a serialised JointState and when it was received [ns]."""
        try:
            self.take(received, self._decode(data))
        except MalformedMessageError as error:
            self.take(received, error)

    def take(self, received: int, sample: JointSample | MalformedMessageError) -> None:
        """Take a joint sample, or why it could not be read, and when it was received [ns]."""
        if isinstance(sample, MalformedMessageError):
            self.malformed += 1
            self.last_error = str(sample)
            return
        stream = self.streams.get(sample.names)
        if stream is None:
            stream = self.streams[sample.names] = JointStream(sample.names)
        stream.add(received, sample)

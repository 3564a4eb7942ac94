# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
How a state becomes the bytes of a message.

Each class here writes one kind of message; all have the same ``encode``.
"""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from .kinematics import State
from .outputs import KINDS
from ..chains.covariance import through_jacobian
from ..messages.stamped import (
    PoseEncoder, TwistEncoder, TwistWithCovarianceEncoder, VelocityEncoder)
from ..screws.rotations import quaternion_from_row

Slices = Mapping[str, slice]


@dataclass(frozen=True)
class Frames:
    """Frame names in messages: of the base, of the tip, and of the vectors' axes."""

    base: str
    tip: str
    axes: str

    @classmethod
    def of(cls, model: Any, prefix: str, expressed_in: str) -> Frames:
        """Return the names for a model, with a prefix, and axes of the 'base' or 'tip'."""
        base, tip = prefix + model.base_frame, prefix + model.tip_frame
        return cls(base, tip, tip if expressed_in == 'tip' else base)


class MessageWriter(Protocol):
    """Writes states as messages of one output."""

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""


def message_writer(output: str, slices: Slices, frames: Frames) -> MessageWriter:
    """
    Return what writes the messages of an output.

    Parameters
    ----------
    output : str
        Any of KINDS but markers and passive joint states.
    slices : mapping from str to slice
        Where the program's outputs are among the values of a state.
    frames : Frames
        Their names in the messages.

    """
    kind = KINDS[output]
    if output == 'pose':
        return PoseWriter(slices['pose'], frames)
    if kind.covariance:
        return CovarianceWriter(slices[kind.needs[0]], slices['jacobian'], kind.order, frames)
    if output == 'velocity':
        return SixVectorWriter(slices[kind.needs[0]],
                               VelocityEncoder(frames.axes, frames.tip, frames.base))
    return SixVectorWriter(slices[kind.needs[0]], TwistEncoder(frames.axes))


class SixVectorWriter:
    """Twist, acceleration, jerk, ...: one six-vector."""

    def __init__(self, at: slice, encoder: TwistEncoder | VelocityEncoder) -> None:
        self._at = at
        self._encoder = encoder

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        return self._encoder.encode(state.stamp_ns, state.values[self._at])


class PoseWriter:
    """The pose, whose rotation becomes a quaternion."""

    def __init__(self, at: slice, frames: Frames) -> None:
        self._at = at
        self._encoder = PoseEncoder(frames.base)

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        pose = state.values[self._at]
        return self._encoder.encode(
            state.stamp_ns, (*pose[:3], *quaternion_from_row(pose[3:])))


class CovarianceWriter:
    """A six-vector and its covariance, from the joints' variances through the Jacobian."""

    def __init__(self, at: slice, jacobian: slice, order: int, frames: Frames) -> None:
        self._at = at
        self._jacobian = jacobian
        n = (jacobian.stop - jacobian.start) // 6
        self._variances = slice(order * n, (order + 1) * n)
        self._encoder = TwistWithCovarianceEncoder(frames.axes)

    def encode(self, state: State) -> bytes:
        """Return the serialized message."""
        covariance = through_jacobian(state.values[self._jacobian],
                                      state.motion.variances[self._variances])
        return self._encoder.encode(state.stamp_ns, (*state.values[self._at], *covariance))

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The measured wrench without the weight and the inertia of what the sensor carries."""
from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from functools import partial
from typing import Any

from .kinematics import State
from .own_motion import Felt, OwnMotion, Slices
from .payload import felt_wrench
from .settings import RobotSettings
from .wrench_sensor import WrenchSensor
from ..errors import Reason
from ..messages.stamped import WrenchEncoder
from ..messages.wrench import WrenchSample
from ..screws.se3 import Array


class WrenchWriter:
    """Writes the wrench at the instant of a state, less what is not contact."""

    def __init__(self, slices: Slices, settings: RobotSettings, sensor: WrenchSensor) -> None:
        self._slices, self._settings, self._sensor = slices, settings, sensor
        self._frame_id = ''
        self._pose: Array | None = None     # of the sensor

    def encode(self, state: State) -> bytes | Reason:
        """Return the serialized message, or why there is no wrench at this instant."""
        sensor = self._sensor
        measured = sensor.at(state.stamp_ns)
        if isinstance(measured, Reason):
            return measured
        if sensor.pose is not self._pose or sensor.frame_id != self._frame_id:
            assert sensor.pose is not None
            self._pose, self._frame_id = sensor.pose, sensor.frame_id
            self._motion = OwnMotion(self._slices, self._settings,
                                     partial(self._contact, sensor.pose), len(measured))
            self._encoder = WrenchEncoder(sensor.frame_id)
        return self._encoder.encode(state.stamp_ns, self._motion.of(state.values, measured))

    def _contact(self, pose: Array, felt: Felt, measured: Array) -> list[Any]:
        """Return the wrench measured at a pose in the tip frame, less that of what it carries."""
        settings = self._settings
        there = felt.at(pose)
        load = felt_wrench(settings.payload.parameters, there.specific_force(settings.gravity),
                           there.omega, there.alpha)
        sign = 1.0 if settings.wrench_by == 'load' else -1.0
        return [w - b - sign * f for w, b, f in zip(measured, settings.wrench_bias, load)]


class Compensation:
    """
    Brings states and wrenches together, whichever comes first.

    A state waits for its wrench until one comes that is later by more than the patience [s].
    """

    def __init__(self, writer: WrenchWriter, sensor: WrenchSensor, patience: float) -> None:
        self._writer, self._sensor = writer, sensor
        self._patience_ns = round(patience * 1e9)
        self._waiting: deque[State] = deque()

    def take_state(self, state: State) -> Iterator[bytes]:
        """Take a state; yield the messages that can be written now."""
        waiting = self._waiting
        if waiting and state.stamp_ns <= waiting[-1].stamp_ns:      # the clock was set
            waiting.clear()
        waiting.append(state)
        while waiting[0].stamp_ns < state.stamp_ns - self._patience_ns:
            waiting.popleft()
            self._sensor.left_out[Reason.NOT_COVERED] += 1
        return self._written()

    def take_wrench(self, sample: WrenchSample) -> Iterator[bytes]:
        """Take a wrench; yield the messages that can be written now."""
        return iter(()) if self._sensor.take(sample) else self._written()

    def _written(self) -> Iterator[bytes]:
        sensor, waiting = self._sensor, self._waiting
        while waiting:
            message = self._writer.encode(waiting[0])
            if message is Reason.AWAITED:
                return
            waiting.popleft()
            if isinstance(message, Reason):
                sensor.left_out[message] += 1
            else:
                sensor.compensated += 1
                yield message

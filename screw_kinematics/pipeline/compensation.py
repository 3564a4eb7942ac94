# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The measured wrench without the weight and the inertia of what the sensor carries."""
from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np

from .kinematics import State
from .own_motion import OwnMotion, Slices
from .payload import felt_wrench
from .settings import RobotSettings
from .wrench_sensor import WrenchSensor
from ..errors import Reason
from ..messages.stamped import WrenchEncoder
from ..messages.wrench import WrenchSample


class WrenchWriter:
    """Writes the wrench at the instant of a state, less what is not contact."""

    def __init__(self, slices: Slices, settings: RobotSettings, sensor: WrenchSensor) -> None:
        self._motion = OwnMotion(slices, settings)
        self._gravity = np.array(settings.gravity)
        self._parameters = settings.payload.parameters
        self._sign = 1.0 if settings.wrench_by == 'load' else -1.0
        self._bias = settings.wrench_bias
        self._sensor = sensor
        self._encoder = WrenchEncoder('')
        self._frame_id = ''

    def encode(self, state: State) -> bytes | Reason:
        """Return the serialized message, or why there is no wrench at this instant."""
        sensor = self._sensor
        measured = sensor.at(state.stamp_ns)
        if isinstance(measured, Reason):
            return measured
        assert sensor.pose is not None
        if sensor.frame_id != self._frame_id:
            self._frame_id = sensor.frame_id
            self._encoder = WrenchEncoder(self._frame_id)
        # Specific force, angular velocity and acceleration, in the tip's axes, then the sensor's.
        felt = self._motion.of(state.values).at(sensor.pose)
        load = felt_wrench(self._parameters, *felt.specific_force(self._gravity))
        return self._encoder.encode(state.stamp_ns, [
            w - b - self._sign * f for w, b, f in zip(measured, self._bias, load)])


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

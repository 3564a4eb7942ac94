# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A force sensor on the tip of a robot: what it says at an instant, and where."""
from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from math import hypot, inf
from typing import Any

from .account import Account
from .settings import RobotSettings
from .side_stream import SideStream
from ..errors import Reason
from ..messages.wrench import WrenchSample
from ..screws.se3 import Array

_FEW = 0.01     # share of the states without a wrench, at both ends of a recording


class WrenchSensor:
    """
    What a force sensor has measured, on one link that is fixed to the tip.

    Kept is all of it, or what the motion may still ask for. Compensated are states of the robot
    that were brought together with a wrench, left out those for which there was none. The frame is
    of the messages, or of the link that the settings name, empty before the first one; the pose
    that of the link in the tip frame, of shape (4, 4) [m], None before the first one.
    """

    def __init__(self, settings: RobotSettings, kept: bool = False) -> None:
        self.settings = settings
        self.account = Account()
        self.compensated = 0
        self.left_out: Counter[Reason] = Counter()
        motion = settings.motion
        gap = motion.options['max_gap']
        span = None if kept else round(1e9 * (motion.delay + settings.stale_timeout + 2 * gap))
        self._stream = SideStream(round(1e9 * gap), span)
        self._frames: Mapping[str, Array] = {}
        self.reset()

    def reset(self) -> None:
        """Forget what was measured, as after a jump of the clock; counts stay."""
        self._stream.clear()
        self.frame_id = self._heard = ''
        self.pose: Array | None = None

    def renewed(self, settings: RobotSettings) -> WrenchSensor:
        """Return this sensor with other settings: its counts go on, what it said is forgotten."""
        sensor = WrenchSensor(settings)
        sensor.account, sensor.left_out = self.account, self.left_out
        sensor.compensated = self.compensated
        return sensor

    def mount(self, model: Any) -> None:
        """Set the robot whose links the sensor may be on."""
        if self._frames is not model.fixed_frames:
            self._frames = model.fixed_frames
            self.reset()

    @property
    def latest_ns(self) -> int | None:
        """Return the stamp of the latest wrench [ns]."""
        return self._stream.latest_ns

    def take(self, sample: WrenchSample) -> Reason | None:
        """Take a message; return why it is of no use, if it is not."""
        reason, detail = self._refusal(sample)
        if reason is None:
            reason = self._stream.add(sample.stamp_ns, sample.values)
        self.account.close(reason, detail)
        return reason

    def at(self, stamp_ns: int) -> tuple[float, ...] | Reason:
        """Return the wrench at an instant, or why there is none: it is awaited, or never comes."""
        return self._stream.at(stamp_ns)

    def findings(self, states: int) -> list[str]:
        """Return what is to be said of a recorded sensor, beside so many states."""
        topic, account = self.settings.wrench_topic, self.account
        found = [f'{topic}: {n} wrenches refused: {account.told(reason)}'
                 for reason, n in account.refused.items()]
        if self.left_out.total() > _FEW * states:
            found.append(f'{topic}: no wrench was measured around {self.left_out.total()} of the '
                         'instants of the joints; do their clocks agree?')
        return found

    def _refusal(self, sample: WrenchSample) -> tuple[Reason | None, str]:
        if sample.stamp_ns < 0:
            return Reason.STAMP_NEGATIVE, f'{sample.stamp_ns * 1e-9:.3f} s'
        if not hypot(*sample.values) < inf:
            return Reason.VALUES_NOT_FINITE, f'{sample.values}'
        if self.pose is None or sample.frame_id != self._heard:
            named = self.settings.wrench_frame
            link = named or sample.frame_id.removeprefix(self.settings.frame_prefix)
            if self.pose is not None and not named or link not in self._frames:
                allowed = ', '.join(self._frames) if self.pose is None else self.frame_id
                return Reason.UNKNOWN_FRAME, (
                    f'frame_id is {sample.frame_id!r}; allowed: {allowed}, or name the link in '
                    f'{self.settings.name}.wrench_frame')
            self._heard = sample.frame_id
            self.frame_id = self.settings.frame_prefix + named if named else sample.frame_id
            self.pose = self._frames[link]
        return None, ''

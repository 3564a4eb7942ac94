# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A further stream beside the joint states, read at the instants of the joints' motion."""
from __future__ import annotations

from bisect import bisect_left

from ..errors import Reason

Values = tuple[float, ...]


class SideStream:
    """
    What was measured beside the joints and has no derivatives known to foresee it by: a wrench.

    It is read between two samples, never beyond the latest one: what is asked for too early is
    awaited, and may be asked for again; samples further apart than a gap are not joined, those
    older than a span forgotten. (The motion of a base has derivatives, and is carried to the
    instant by them, so that no state waits for odometry: :class:`.moving_base.MovingBase`.)

    Examples
    --------
    >>> stream = SideStream(max_gap_ns=10)
    >>> stream.add(20, (1.0, 0.0)), stream.add(28, (3.0, 4.0)), stream.add(28, (0.0, 0.0))
    (None, None, <Reason.STAMP_NOT_INCREASING: 'stamp_not_increasing'>)
    >>> stream.at(22), stream.at(28)
    ((1.5, 1.0), (3.0, 4.0))
    >>> stream.at(30), stream.at(10)
    (<Reason.AWAITED: 'other_stream_awaited'>, <Reason.NOT_COVERED: 'other_stream_has_a_gap'>)

    """

    def __init__(self, max_gap_ns: int, span_ns: int | None = None) -> None:
        self._max_gap_ns, self._span_ns = max_gap_ns, span_ns
        self._backward_ns = 2 * max_gap_ns
        self.clear()

    def clear(self) -> None:
        """Forget all samples."""
        self._stamps: list[int] = []
        self._values: list[Values] = []

    @property
    def latest_ns(self) -> int | None:
        """Return the stamp of the latest sample [ns]."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp_ns: int, values: Values) -> Reason | None:
        """
        Take a sample; return why it is of no use, if it is not.

        One far earlier than all before, as of a clock that was set, begins the stream anew.
        """
        stamps = self._stamps
        if stamps and stamp_ns <= stamps[-1]:
            if stamp_ns >= stamps[-1] - self._backward_ns:
                return Reason.STAMP_NOT_INCREASING
            self.clear()
            stamps = self._stamps
        stamps.append(stamp_ns)
        self._values.append(values)
        if self._span_ns is not None and stamps[len(stamps) // 2] < stamp_ns - self._span_ns:
            old = bisect_left(stamps, stamp_ns - self._span_ns) - 1
            del stamps[:old], self._values[:old]
        return None

    def at(self, stamp_ns: int) -> Values | Reason:
        """Return the values at an instant, on the line between two samples; or why not."""
        stamps = self._stamps
        after = bisect_left(stamps, stamp_ns)
        if after == len(stamps):
            return Reason.AWAITED
        values = self._values[after]
        if stamps[after] == stamp_ns:
            return values
        step = stamps[after] - stamps[after - 1] if after else 0
        if not 0 < step <= self._max_gap_ns:
            return Reason.NOT_COVERED
        share = (stamp_ns - stamps[after - 1]) / step
        return tuple([a + share * (b - a) for a, b in zip(self._values[after - 1], values)])

# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How many ticks of the device have passed, and where the stamps' clock has them."""

from __future__ import annotations

from collections import deque
from math import hypot, inf, log, sqrt

from ..core.robust_line import Line

Ticks = int
"""A number of ticks; under this name Cython 3.0.8 takes the type of C that is in the .pxd."""

LONGEST = 2.0
"""Memory of phase and period, s."""

PAIRS = 256
"""Pairs of tick and stamp, at most, through which the line is drawn."""

FEWEST = 16
"""Pairs from which on there is a line."""

SOUND = 0.05
"""For how long pairs are sound, at least, where the period proves wrong, s: the slope of fewer is
rather noise."""

LATE = 12
"""Stamps in a row that must all be late for their clock to have been set."""

CATCHES_UP = 0.05
"""Periods by which lateness falls with each message from which on no clock was set, but a stall
ends; beside twice the stamps' deviation."""

STALL = 8.0
"""Mean deviations of stamps beyond which, and a period, messages that catch up were held up."""

SURPRISE = 5.0
"""Log odds against an acceleration that nobody foresaw."""

WRONG = 10.0
"""Log odds up to which positions can be wrong about the ticks that passed."""

MOST_TICKS = 400
"""Ticks that can pass between two readings."""


class TickCounter:
    """
    Count ticks by two witnesses: when the reading was stamped, and how far the joints went.

    Stamps are late with a long tail, and early hardly ever. Positions foretell a number of
    ticks, unless an acceleration came that nobody foresaw, or they are wrong. How often each
    number has occurred is the third to be heard. The stamps' own clock is a robust line through
    the pairs of tick and stamp of the last seconds; it never moves a measurement.
    """

    def __init__(self, phase: float, period: float, count: int, deviation: float) -> None:
        # Stamp of the present tick, and period of the device by the stamps' clock, s; how many
        # stamps both are known from.
        self.phase, self.period, self.count = phase, period, count
        self.tick = 0.0
        # Mean deviation of stamps from their ticks, s; of those behind, and of those early.
        self.deviation = self.behind = self.early = deviation
        self.lean = 0.0
        """Mean sign of the deviation, of late."""
        self.sets = 0.0
        """How often the stamps' clock was set, of late."""
        self.shift = 0.0
        """By how much the stamps' clock was set in all, s."""
        self.unseen = 0.0
        """Ticks since the latest pair of the line."""
        self.line = Line(PAIRS)
        self._due = count + 8
        self._recent: deque[float] = deque(maxlen=LATE)
        self._before = 0.0
        # What the slope may be off by that was known when the line began.
        self._known = inf
        self.forget_steps()

    def fresh(self, stamp: float) -> TickCounter:
        """Return a counter of the same device that begins with a stamp."""
        counter = TickCounter(stamp, self.period, 1, self.deviation)
        counter.behind, counter.early = self.behind, self.early
        counter.often, counter.total = dict(self.often), self.total
        counter._weight = self._weight
        return counter

    def forget_steps(self) -> None:
        """Know no more how often each number of ticks has occurred."""
        self.often = {1: 9.0}
        self.total = 10.0
        self._weight = 1.0

    def line_error(self) -> tuple[float, float]:
        """
        Return what the line's stamp of the present tick may be off, s, and its slope.

        Two standard errors of its mean where it ends, and as many of its slope since then.
        """
        return self._line_error(self.deviation / sqrt(max(self.line.pairs(), 1)))

    def stated_error(self) -> tuple[float, float]:
        """Return the same as the line's own deviations have it, where these are enough."""
        error = self.line.error
        return self._line_error(error) if error else self.line_error()

    def _line_error(self, mean: float) -> tuple[float, float]:
        end = 2.0 * mean
        rate = min(sqrt(12.0) * end / (max(self.line.ticks(), 1.0) * self.period), self._known)
        return hypot(end, rate * self.unseen * self.period), rate

    def vague(self) -> bool:
        """Whether no stamp alone tells its tick."""
        return self.deviation > 0.15 * self.period

    def begin_line(self) -> None:
        """Draw the line through pairs to come alone: nobody has told the ticks before these."""
        self._known = self.line_error()[1]
        self.line = Line(PAIRS)
        self._due = self.count + FEWEST

    def usual(self) -> bool:
        """Whether nearly always one tick passes."""
        return self.often.get(1, 0.0) > 0.5 * self.total

    def number(self, stamp: float, x: float, foreseen: float, unforeseen: float,
               repeats: float) -> int:
        """
        Return the most likely number of ticks since the last reading; 0: it is the same one.

        The stamp, s, is of the new reading; ``x`` are ticks that the joints have travelled. Its
        deviation from the number of ticks is ``foreseen``, as usual, and ``unforeseen``, for an
        acceleration that nobody foresaw. Where it can be the same reading, ``repeats`` are log
        odds against encoders that repeat themselves from one tick to the next; else infinite.
        """
        period, lateness = self.period, stamp - self.phase
        behind, early = max(self.behind, 0.02 * period), max(self.early, 0.01 * period)
        if (foreseen < 0.3 and unforeseen < 1.0 and -0.35 < x - 1.0 < 0.35
                and -early < lateness - period < 2 * behind and self.usual()):
            return 1
        near = round(lateness / period)
        by_joints = round(x) if foreseen < 1.0 else near
        lowest, highest = min(near, by_joints, 2) - 1, max(near, by_joints, 0) + 1
        # Densities: what nobody foresaw is spread wider, too.
        surprise = SURPRISE + (log(unforeseen / foreseen) if unforeseen > foreseen else 0.0)
        best, found = inf, 1
        for d in range(max(lowest, 0 if repeats < inf else 1), min(highest, MOST_TICKS) + 1):
            if abs(d - near) > 1 and abs(d - by_joints) > 1 and d != 1:
                continue
            late = lateness - d * period
            if d == 0:      # the same reading is sent again at any time before the next one
                cost = min(max(late - period, 0.0) / behind, 8.0)
            elif late > 0.0:
                cost = min(late / behind, 8.0)
            else:       # a reader's stamps may all be late by as much as a tick
                cost = late / early
                cost = min(0.5 * cost * cost, 6.0 if late > -1.2 * period else 20.0)
            off = (x - d) * (x - d)
            cost += min(d * repeats, 0.5 * off / (foreseen * foreseen),
                        surprise + 0.5 * off / (unforeseen * unforeseen), WRONG)
            cost += self.surprise(d)
            if cost < best - 1e-9:
                best, found = cost, d
        return found

    def surprise(self, d: Ticks) -> float:
        """Return the log odds against d ticks, as often as they have passed so far."""
        return -log(max(self.often.get(d, 0.0) / self.total, 0.005))

    def note(self, d: Ticks) -> None:
        """Remember that d ticks have passed between two readings."""
        self._weight *= 1.02
        self.often[d] = self.often.get(d, 0.0) + self._weight
        self.total += self._weight
        if self._weight > 1e6:
            self.often = {k: w / self._weight for k, w in self.often.items()
                          if w > 1e-3 * self._weight}
            self._weight = 1.0
            self.total = sum(self.often.values())

    def advance(self, d: Ticks, stamp: float, sure: bool) -> float:
        """
        Go on by d ticks, at least 1; return by how much the stamp is later than the tick, s.

        `sure`: the line may be drawn through this pair.
        """
        self.note(d)
        period = self.period
        self.phase += d * period
        late = stamp - self.phase
        self.count += 1
        self.tick += d
        self.unseen += d
        # What a stall has held up tells nothing of how stamps usually are.
        recent = self._recent
        held_up = (late > period + STALL * self.deviation and len(recent) > 2
                   and self._catching_up(recent[-3] - late, 3))
        if not held_up:
            self._learn(late)
        self.sets *= 0.95
        recent.append(late)
        shift = self._set_by(late) if self.count > 16 else 0.0
        if shift:
            self.phase += shift
            late -= shift
            self._before = late
            recent.clear()
            self.sets += 1.0
            if self.lean * shift > 0.6 * abs(shift):    # so for long: the period is wrong
                self.forget(max(24 * self.line.stride, int(SOUND / period)))
            else:
                self.shift += shift
        if sure and not held_up:
            if self.line.full() and self.line.ticks() < LONGEST / period:
                self.line.merge()
            self.line.add(self.tick, stamp - self.shift)
            self.unseen = 0.0
        if self.count >= self._due:
            self._due = self.count + min(
                max(8, self.count // 8), max(8, int(0.05 / period)))
            self._fit()
        return late

    def _learn(self, late: float) -> None:
        """Follow how late and early stamps are, as a rule."""
        # Comparisons, as calls of min and max would take longer than all else here.
        gain = 1.0 / self.count if self.count < 100 else 0.01
        most = 7.0 * self.deviation if self.deviation > 1e-6 else 7e-6
        # Of steps, so that an offset is no deviation.
        wobble = 0.7 * abs(late - self._before)
        self.deviation += ((wobble if wobble < most else most) - self.deviation) * gain
        self._before = late
        if late > 0.0:
            self.behind += ((late if late < most else most) - self.behind) * gain
            self.lean += 0.03 * (1.0 - self.lean)
        else:
            self.early += ((-late if -late < most else most) - self.early) * gain
            self.lean += 0.03 * (-1.0 - self.lean)

    def _set_by(self, late: float) -> float:
        """Return by how much the stamps' clock seems to have been set, s."""
        recent = self._recent
        tolerance = 0.1 * self.period + 4.0 * self.deviation
        if -tolerance <= late <= tolerance:
            return 0.0
        # Where a line ends that goes through few stamps, or none of late, is not well known.
        tolerance += 4.0 * self.line_error()[0]
        if late < -3.0 * tolerance - self.period:
            return late
        if late < -tolerance:                           # never early: at once
            if len(recent) > 1 and recent[-2] < -tolerance:
                return max(late, recent[-2])
        elif late > tolerance and len(recent) > 3:
            four = recent[-4], recent[-3], recent[-2], late
            least = min(four)
            if (least > tolerance and max(four) - least < 0.25 * least      # evenly late
                    and not self._catching_up(four[0] - late, 3)):
                return least
            if (len(recent) == LATE and late > 0.5 * recent[0]
                    and not self._catching_up(recent[0] - late, LATE - 1)):
                least = min(recent)
                if least > tolerance:
                    return least
        return 0.0

    def _catching_up(self, fallen: float, messages: float) -> bool:
        """Whether lateness that fell so much over some messages is that of who was held up."""
        return fallen > CATCHES_UP * messages * self.period + 2.0 * self.deviation

    def forget(self, last: int) -> None:
        """Forget all pairs but the latest; the others are not sound."""
        self.line.keep(last)
        self._due = self.count

    def coarsen(self, factor: int) -> None:
        """Let ticks be longer: all steps were multiples of `factor`."""
        self.period *= factor
        self.line.rescale(self.tick, factor)
        self.tick = 0.0
        self.forget_steps()

    def recounted(self, numbers: list[float], stamps: list[float], at_zero: float,
                  period: float, deviation: float) -> TickCounter:
        """
        Return a counter of the ticks that the latest readings are found to be of.

        Numbers are their ticks from 0, beside their stamps, s. Of the line through both: the stamp
        at tick 0, s; its slope, which is the period; and its mean deviation, s.
        """
        count, last = len(numbers), numbers[-1]
        known = (abs(period - self.period) < 10.0 * deviation / max(last, 1.0) / sqrt(count)
                 and self.count > 2 * count and last == count - 1)
        new = (TickCounter(self.phase, self.period, max(self.count, count), deviation) if known
               else TickCounter(at_zero + period * last, period, count, deviation))
        for a, b in zip(numbers, numbers[1:]):
            new.note(int(b - a))
        if known:               # the longer memory knows better
            new.line, new.tick, new.shift = self.line, self.tick, self.shift
        else:
            for number, stamp in zip(numbers, stamps):
                new.line.add(number - last, stamp)
        return new

    def _fit(self) -> None:
        if self.line.pairs() < FEWEST:
            return
        phase, period, _ = self.line.fit(self.tick)
        if self.line_error()[1] == self._known:     # the line is too short to know better
            half = 0.5 * self.line.ticks()
            self.phase = self.line.fit(self.tick - half)[0] + half * self.period + self.shift
        elif period > 0.2 * self.period:
            self.phase, self.period, self._known = phase + self.shift, period, inf

# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""When each reading was taken, in the time of the device that took it."""
from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from math import dist, hypot, inf, sqrt

from .clock_error import ClockError
from .clock_findings import clock_doubts, clock_error, HOLDS, Tally
from .first_ticks import count_by, FIRST, FirstTicks
from .held_readings import HeldReadings
from .numbers import Row
from .stamp_share import BLOCK, KNOWN, StampShare
from .tick_counter import TickCounter
from ..core.bank import Bank
from ..core.period_search import PeriodSearch
from ..core.readings import Readings

WINDOW = 40
"""Readings that are searched for a period."""

JITTER = 0.08
"""Mean deviation of the first stamps from a line, in periods, from which on ticks are believed
until the joints say otherwise."""

ADOPT = 12.0
"""Log likelihood ratio from which on another counting of ticks is adopted."""

UNFORESEEN = 50.0
"""Acceleration of all joints together that may come from one reading to the next, rad/s^2."""

FAR = 12
"""Ticks beyond which the filters do not foresee where the joints will be."""

FEW_TICKS, LONG = 3, 0.03
"""So they do not beyond this many ticks if these take longer than this, s."""

NEXT = 0.35
"""Ticks by which joints may be from where they go on to in a reading that is merely late."""

TOLD = 0.25
"""Ticks by which joints may be from where they are foreseen once they have told the ticks."""

STEPS = 2.5
"""Steps of the encoder that joints move in a tick, at least, for positions to tell ticks."""

REGULAR = 0.05
"""Deviation of stamps from their ticks, in periods, up to which they are right about a pause."""

NOTHING = 2e-3
"""Deviation of stamps from their ticks, in periods, up to which it does not matter."""


class Placed:
    """
    Where a message is in the device's time.

    Attributes
    ----------
    time : float or None
        When its reading was taken, s; None for a reading that was there before.
    instant : float
        The device's time at the message's stamp, s.
    rate : float
        Seconds of the stamps' clock in a second of the device's.
    age : float
        How long before the message's stamp the latest reading was first sent, s.
    replay : list of (float, tuple) or None
        The latest readings and their times, where these have turned out otherwise.

    """

    def __init__(self, time: float | None, instant: float, rate: float, age: float,
                 replay: list[tuple[float, Row]] | None) -> None:
        self.time = time
        self.instant = instant
        self.rate = rate
        self.age = age
        self.replay = replay


class DeviceClock:
    """
    The clock of the device that reads the joints, from stamps and positions.

    A device reads at regular ticks; messages repeat, skip, delay and mis-stamp the readings. For
    each message it is *counted* how many ticks passed since the last reading (`TickCounter`); the
    reading is *placed*: device time goes on by whole ticks, and by that share of the stamp's
    deviation which is true (a sampler that wobbles and knows it, not late arrival); the message's
    stamp is *mapped* to device time by the line through ticks and stamps. The *period* begins as
    that of the messages; other countings are tried while the joints move.

    Parameters
    ----------
    n_joints : int
        Number of joints.

    """

    def __init__(self, n_joints: int) -> None:
        self._readings = Readings(n_joints, WINDOW)
        self._periods = PeriodSearch(self._readings)
        self.start(0.0, (0.0,) * n_joints)

    def start(self, stamp: float, position: Row,
              known: DeviceClock | None = None) -> None:
        """Begin a run with a reading; what `known` has found of the device is known at once."""
        self.ticks: TickCounter | None = None
        self.unit = 0.0
        """A tick in device time, s; 0 while it is not known."""
        self.share = 1.0
        """Share of a stamp's deviation from its tick that is true."""
        self.proven = False
        """Whether the joints have shown it."""
        self.held, self.fresh, self.lost = 0, 1, 0
        """Messages that repeated a reading, that brought one, ticks that none was of."""
        self._begun = FirstTicks(stamp)
        self._repeated = HeldReadings(stamp, position)
        self._shares = StampShare()
        self._first = self._last = self._heard = self._time = stamp
        self._position = position
        self._tick = self._deviation = self._ahead = self._wrong = 0.0
        self._ratio, self._messages, self._spacing, self._doubt = 1.0, 0.0, 0.0, 0.0
        self._readings.clear()
        self._new, self._rest, self._contrary = 0, 8, 0
        self._patience, self._wait, self._told, self._lossy = 1.0, 0.0, 0, False
        self._foreseen: float | None = None
        if known is not None and known.ticks is not None:
            self.ticks = known.ticks.fresh(stamp)
            self.unit = self.ticks.period
            self.share, self.proven = known.share, True
            self._lossy, self._foreseen = known._lossy, known._foreseen
            self._repeated = HeldReadings(stamp, position, known._repeated.hold,
                                          known._repeated.quantum)
            self._shares = copy(known._shares)

    @property
    def period(self) -> float:
        """Return the device's period, s; 0 while it is not known."""
        return 0.0 if self.ticks is None else self.ticks.period

    @property
    def error(self) -> ClockError:
        """Return what none can know of the device's time."""
        ticks = self.ticks
        if self.share > 0.5 and (self.proven or ticks is None or self.held <= HOLDS and (
                ticks.deviation <= JITTER * ticks.period)):
            ticks = None
        return clock_error(ticks, self._tally(), self._spacing, self._doubt)

    def update(self, stamp: float, position: Row, bank: Bank | None) -> Placed:
        """
        Place a message.

        Parameters
        ----------
        stamp : float
            Later than that of the message before, s.
        position : tuple of float
            Its positions.
        bank : FilterBank, optional
            What foresees the positions; None while it has not settled.

        """
        same = position == self._position
        # Also those that did not come: a pause does not make the others come slower.
        steps = (stamp - self._heard) / self._spacing if self._messages > 4.0 else 1.0
        self._messages += round(steps) if steps > (1.5 if self._messages > WINDOW else 4.0) else 1
        self._heard, self._spacing = stamp, (stamp - self._first) / self._messages
        ticks = self.ticks
        if ticks is None:
            return self._begin(stamp, position, same)
        period, unit = ticks.period, self.unit
        agreed = position
        x, foreseen, unforeseen, length, usual = 0.0, 1e3, 1e3, 0.0, 0.0
        near = round((stamp - ticks.phase) / period)
        if bank is not None:
            span = (near if 0 < near < FAR else 1) * unit
            x, length, agreed = bank.travel(position, unit, span, UNFORESEEN)
            usual = length if self._foreseen is None else self._foreseen
            foreseen = max(usual / length, 0.15)
            unforeseen = UNFORESEEN * span * span / length
        told = foreseen < 0.3
        age = stamp - self._last
        if same and self._repeated.repeats(stamp, age, length, unit, bank):
            d = 0
        else:
            d = ticks.number(stamp, x, foreseen, unforeseen, same and age < 3.5 * period)
        # Regular stamps that are not proven to be of another clock are right about a loss; all are
        # about a pause longer than the filters foresee, unless what comes after it is merely late.
        regular = ticks.deviation < REGULAR * period and not (self.proven and self.share < 0.5)
        # One that is late already was none, so its time has passed since the last message.
        pause = d > 0 and (near >= FAR or near > FEW_TICKS and age > LONG) and (
            2.0 * age > near * period) and not (
            told and bank is not None and self._goes_on(position, x, unit, bank))
        if pause:
            d = near
            if not (regular or self.proven):
                self.begin_anew()                       # it may be no clock at all
                return self._begin(stamp, position, same)
        if d and same and self._repeated.standing:
            self._repeated.stopped(position)
            self._time += age * self._ratio
            self._last = stamp
            ticks.advance(d, stamp, False)
            self._tick += d
            return Placed(self._time, self._time, 1.0 / self._ratio, 0.0,
                          [(self._time, position)])
        if d == 0:
            self.held += 1
            ticks.note(0)
            return Placed(None, self._time + self._ahead + age * self._ratio,
                          1.0 / self._ratio, age, None)
        self.fresh += 1
        if not pause:
            self.lost += d - 1
        if bank is not None and not same and not pause:
            off = min(abs(x - d) * length, 3.0 * usual)
            self._foreseen = off + 1e-9 if self._foreseen is None else sqrt(
                0.95 * usual * usual + 0.075 * off * off)
        step = age - d * period
        span = age * self._ratio
        # Else the stamp was set, or is late: the count alone.
        most = 0.1 * period + 5.0 * ticks.deviation
        agree = abs(step) < most and (
            self.share == 1.0 or abs(stamp - ticks.phase - d * period) < most)
        if pause:
            told = False
            self._readings.clear()
            self._new = 0
        if pause or abs(x - d) > NEXT:
            agreed = position       # the joints were not where they were foreseen
        if agree:
            self._deviation += step
        if not same:
            self._repeated.moved(stamp, position, d, False)
        self._last, self._position = stamp, position
        self._tick += d
        before = ticks.deviation > 0.15 * period        # whether the stamps cannot tell
        if told:
            self._wrong += 0.05 * ((abs(x - d) > 0.35 and not agree) - self._wrong)
            self._told += 1
            if d > 1 and before and not self._lossy:
                # Some were lost, unseen while the joints rested.
                self._lossy = True
                ticks.forget(self._told)
        late = ticks.advance(d, stamp, told or not (before and self._lossy))
        if self.share < 1.0:
            self._ratio = unit / period                 # stamps alone need none
        paced = False
        if agree:
            onward = span if self.share == 1.0 else d * unit + self.share * step * self._ratio
        elif regular or pause:
            paced = True
            by_joints = told and (near < FAR or abs(x - d) < 0.35 and near > d + 1)
            onward = d * unit if by_joints and abs(d - x) * unit <= abs(span - x * unit) else span
        elif told:
            onward = d * unit + self.share * min(max(x - d, -0.2), 0.2) * unit
        else:
            onward = d * unit
        # Late again and again, or early: these are not the ticks. Who catches up is late, less.
        self._contrary = 0 if agree else self._contrary + (
            paced and (step > 0.0 or late < 0.0))
        self._time += max(onward, 0.1 * unit)
        off = abs(late) if ticks.deviation < REGULAR * period else 0.0    # late, or a clock set
        self._doubt = off if off > most else 0.0
        self._ahead = late * (1.0 - self.share * agree) * self._ratio
        if not same:
            self._readings.add(self._tick, self._deviation, stamp, self._time, agreed)
            self._new += 1
        if not self.proven and ticks.count == 2 * FIRST and ticks.deviation > JITTER * period:
            self.share = 0.0
        replay = None
        if not same and self._new >= self._rest and self._readings.number() >= BLOCK:
            replay = self._judge()
        if self._wrong > 0.4 or self._contrary > 2 or (
                self.ticks is ticks and ticks.sets > 3.0 and abs(ticks.lean) > 0.8):
            replay = self.begin_anew() or replay
        return Placed(self._time, self._time + self._ahead, 1.0 / self._ratio, 0.0, replay)

    def _goes_on(self, position: Row, x: float, unit: float, bank: Bank) -> bool:
        """Whether a reading after a pause is the next one, late: all joints go on by a tick."""
        d = round(x)
        if not 0 < d < FEW_TICKS:
            return False
        n, state = len(position), bank.state()
        span = d * unit
        move = [span * (state[n + j] + 0.5 * span * state[2 * n + j]) for j in range(n)]
        return dist(position, [state[j] + move[j] for j in range(n)]) < (
            NEXT * hypot(*move) / d)

    def _begin(self, stamp: float, position: Row, same: bool) -> Placed:
        """Place a message by its stamp, before there are ticks."""
        age = stamp - self._last
        if same and self._repeated.repeats(stamp, age, 0.0, 0.0, None):
            if not self.held:
                self._begun = FirstTicks(self._last)    # what repeated before was no reading
            self.held += 1
            return Placed(None, self._time + age * self._ratio, 1.0 / self._ratio, age, None)
        self.fresh += 1
        if not same:
            self._repeated.moved(stamp, position, 1, True)
        self._time += age * self._ratio
        self._last, self._position = stamp, position
        if not same:
            self._readings.add(0.0, 0.0, stamp, self._time, position)
        self.ticks = ticks = self._begun.add(stamp)
        if ticks is not None:
            self.unit = ticks.period * self._ratio
            self._count_first(ticks)
        return Placed(self._time, self._time, 1.0 / self._ratio, 0.0, None)

    def _count_first(self, ticks: TickCounter) -> None:
        """Put the readings so far on the first ticks."""
        readings, phase, period = self._readings, ticks.phase, ticks.period
        rows = [readings.at(i) for i in range(readings.number())]
        for i, (k, (*_, stamp, time)) in enumerate(zip(
                count_by(phase, period, [row[2] for row in rows], 0), rows)):
            readings.place(i, k, stamp - phase - k * period, time)
        self._tick, self._deviation = 0.0, self._last - phase

    def begin_anew(self) -> list[tuple[float, Row]] | None:
        """Go by the stamps, since the ticks are not what they were; count anew."""
        replay = (self._readings.by_stamps(self._time)
                  if self._readings.number() >= BLOCK else None)
        self._ratio = 1.0
        self.ticks, self._begun = None, FirstTicks(self._last)
        self.share, self.proven, self._wrong, self._ahead = 1.0, False, 0.0, 0.0
        self._contrary = 0
        self._readings.clear()
        self._shares = StampShare()
        self._rest, self._wait, self._patience = 8, 0.0, 1.0
        return replay

    # ---- what the joints say

    def _judge(self) -> list[tuple[float, Row]] | None:
        """Let the latest readings tell how much of the stamps is true, and of which ticks."""
        ticks = self.ticks
        assert ticks is not None
        self._new = 0
        readings = self._readings
        replay = None
        common = readings.divisor(BLOCK)
        if common > 1 and (self._repeated.hold > 0.0 or self._told >= BLOCK):
            self._coarsen(common)
        new = readings.regress(BLOCK, ticks.period)
        if not any(new):
            return None
        if ticks.deviation > NOTHING * ticks.period:
            share = self._shares.learn(*new)
            if share is not None:
                self.share = share
                if not self.proven and share < 0.5:
                    replay = self._search() or readings.by_ticks(
                        self._time, self.unit, share * self.unit / ticks.period)
                self.proven = True
        blocks = self._shares.blocks
        if blocks >= KNOWN:
            self._rest = max(8, min(64, int(0.05 / self.unit)))
        elif (self.share == 1.0 and self._repeated.hold == 0.0
                and self._last - readings.at(-BLOCK)[2] > 0.06):
            self._rest = 4
        else:
            self._rest = 8
        self._wait -= 1.0
        if self.share > 0.2 and self._wait <= 0.0:
            replay = self._search() or replay
        return replay

    def _coarsen(self, common: int) -> None:
        """Let ticks be longer: all steps were multiples, of late and long before."""
        ticks = self.ticks
        assert ticks is not None
        if sum(w for d, w in ticks.often.items() if d % common) > 1e-3 * ticks.total:
            return
        ticks.coarsen(common)
        self.unit *= common
        self._readings.rescale(self._tick, common)
        self._tick = 0.0

    def _search(self) -> list[tuple[float, Row]] | None:
        """Try other countings of the latest readings; adopt one that is proven."""
        ticks, readings = self.ticks, self._readings
        assert ticks is not None
        number = self._periods.since_moving()
        if number < BLOCK:
            return None
        if number >= 30:        # a long window that tells nothing
            self._wait = self._patience
            self._patience = min(1.5 * self._patience, 40.0)
        readings.drop(readings.number() - number)
        found = self._periods.search(ticks.deviation, ticks.period)
        if found is None or found[0] < ADOPT:
            return None
        _, numbers, at_zero, slope, deviation = found
        move = dist(readings.position(number - 1), readings.position(0)) / numbers[-1]
        if move < STEPS * self._repeated.quantum < inf:
            return None     # what looks like ticks are the encoder's steps
        self.ticks = ticks = ticks.recounted(
            numbers, [readings.at(i)[2] for i in range(number)], at_zero, slope, deviation)
        period, last = ticks.period, numbers[-1]
        self.unit, self._ratio = period, 1.0
        self.share, self.proven, self._wrong = 0.0, True, 0.0
        self._tick, self._ahead = last, self._last - ticks.phase
        # The joints have told these ticks from others, and the rest of the messages from ticks.
        self._foreseen = TOLD * move
        for _ in range(round((self._last - readings.at(0)[2]) / self._spacing) - number + 1):
            ticks.note(0)
        replay = []
        for i, k in enumerate(numbers):
            e = readings.at(i)[2] - (at_zero + slope * k)
            time = self._time + (k - last) * period
            readings.place(i, k, e, time)
            replay.append((time, readings.position(i)))
            self._deviation = e
        self._shares, self._rest, self._wait = StampShare(), 8, 0.0
        return replay

    # ---- what it has found

    def doubts(self) -> Sequence[str]:
        """Return what the clock has found, if the stamps are not when joints were read."""
        return clock_doubts(
            self.ticks if self.proven and self.share <= 0.5 else None, self._tally())

    def _tally(self) -> Tally:
        return Tally(self.held, self.fresh, self.lost)

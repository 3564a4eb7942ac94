# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""When each reading was taken, in the time of the device that took it."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from math import dist, hypot, inf, sqrt

from .tick_counter import TickCounter
from ..core.bank import Bank
from ..core.period_search import PeriodSearch
from ..core.readings import Readings
from ..core.robust_line import Line

WINDOW = 40
"""Readings that are searched for a period."""

BLOCK = 12
"""Readings from which it is found at a time how much of a stamp's deviation is true."""

FIRST = 20
"""Messages from which a first period is taken."""

PAUSE = 8.0
"""Steps of the first stamps, in periods, beyond which they tell nothing of the period."""

JITTER = 0.08
"""Mean deviation of the first stamps from a line, in periods, from which on ticks are believed
until the joints say otherwise."""

LATEST, IRREGULAR = 1e-2, 0.3
"""Mean deviation of the first stamps from a line, s and in periods, beyond which they are of no
clock: readings come when they come."""

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

REGULAR = 0.05
"""Deviation of stamps from their ticks, in periods, up to which they are right about a pause."""

FEW = 100
"""Readings from which on the clock is told of."""

NOTHING = 2e-3
"""Deviation of stamps from their ticks, in periods, up to which it does not matter."""

HELD_MOST = 0.1
"""A reading that repeats for longer is of joints that stand, s."""

STEPS_SEEN = 2.5
"""Steps of the encoder that a joint must move in a tick for a repetition to be no reading."""

WORTH_TELLING = 1e-6
"""Stamps that jitter by less are rounded, as floats of seconds since 1970 are, s."""

HOLDS, SKIPS = 2, 0.3
"""Readings that were held, or ticks that were skipped for each reading, from which on who reads
is taken to have a clock of its own."""

REMEMBERED = 2.0
"""How long ticks and stamps count for their line, s."""


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
    replay : list of (float, array) or None
        The latest readings and their times, where these have turned out otherwise.

    """

    def __init__(self, time: float | None, instant: float, rate: float, age: float,
                 replay: list[tuple[float, array[float]]] | None) -> None:
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
        self._agreed = array('d', bytes(8 * n_joints))
        self.start(0.0, self._agreed)

    def start(self, stamp: float, position: array[float],
              known: DeviceClock | None = None) -> None:
        """Begin a run with a reading; what `known` has found of the device is known at once."""
        self.ticks: TickCounter | None = None
        self.unit = 0.0
        """A tick in device time, s; 0 while it is not known."""
        self.share = 1.0
        """Share of a stamp's deviation from its tick that is true."""
        self.proven = False
        """Whether the joints have shown it."""
        self.hold = 0.0
        """For how long readings are held, s."""
        self.held, self.fresh, self.lost = 0, 1, 0
        """Messages that repeated a reading, that brought one, ticks that none was of."""
        self._stamps = [stamp]
        self._first = self._last = self._time = stamp
        self._position = position
        self._tick = self._deviation = self._ahead = 0.0
        self._ratio = 1.0
        self._readings.clear()
        self._new, self._rest = 0, 8
        self._patience, self._due, self._told, self._lossy = 1.0, 0.0, 0, False
        self._foreseen: float | None = None
        self._wrong, self._contrary = 0.0, 0
        self._quantum = inf
        self._same = 0
        # A reading, the one before, when it came, and for how long that one was held.
        self._moved: tuple[array[float], array[float] | None, float, float] = (
            position, None, stamp, 0.0)
        self._steps = (position, position, 1), (position, position, 1)
        self._standing = False
        self._squares = [0.0, 0.0, 0.0]
        self._blocks = 0
        if known is not None and known.ticks is not None:
            self.ticks = known.ticks.fresh(stamp)
            self.unit = self.ticks.period
            self.share, self.proven, self.hold = known.share, True, known.hold
            self._lossy, self._foreseen, self._quantum = (
                known._lossy, known._foreseen, known._quantum)
            self._squares, self._blocks = list(known._squares), known._blocks

    @property
    def period(self) -> float:
        """Return the device's period, s; 0 while it is not known."""
        return 0.0 if self.ticks is None else self.ticks.period

    @property
    def unknown(self) -> float:
        """
        Return the standard deviation of the device's time at a stamp that none can know, s.

        Who reads by another clock takes readings that are up to a period old; where both beat
        slowly, the joints tell the ticks, but nothing tells what is between.
        """
        ticks, count = self.ticks, self.held + self.fresh
        if ticks is None or self.share > 0.5 or count < FIRST or not (
                self.held > HOLDS or self.lost > SKIPS * self.fresh):
            return 0.0
        device, messages = ticks.period, (self._last - self._first) / (count - 1)
        shorter, longer = min(device, messages), max(device, messages)
        # The line through the stamps averages a beat that is faster than it remembers.
        beats = abs(longer / shorter - round(longer / shorter)) * REMEMBERED / longer
        return shorter / sqrt(12.0) / max(1.0, beats)

    def update(self, stamp: float, position: array[float], bank: Bank | None) -> Placed:
        """
        Place a message.

        Parameters
        ----------
        stamp : float
            Later than that of the message before, s.
        position : array
            Its positions.
        bank : FilterBank, optional
            What foresees the positions; None while it has not settled.

        """
        same = position == self._position
        self._same += same
        ticks = self.ticks
        if ticks is None:
            return self._begin(stamp, position, same)
        period, unit = ticks.period, self.unit
        agreed = position
        x, foreseen, unforeseen, length, usual = 0.0, 1e3, 1e3, 0.0, 0.0
        near = round((stamp - ticks.phase) / period)
        if bank is not None:
            span = (near if 0 < near < FAR else 1) * unit
            agreed = self._agreed
            x, length = bank.travel(position, unit, span, UNFORESEEN, agreed)
            usual = length if self._foreseen is None else self._foreseen
            foreseen = max(usual / length, 0.15)
            unforeseen = UNFORESEEN * span * span / length
        told = foreseen < 0.3
        age = stamp - self._last
        self._standing = same and bank is not None and (
            self._standing or self._stands(length, bank))
        if same and (age < 1.3 * self.hold or self._standing and age < HELD_MOST):
            d = 0
        else:
            d = ticks.number(stamp, x, foreseen, unforeseen, same and age < 3.5 * period)
        # Regular stamps that are not proven to be of another clock are right about a loss; all
        # are about a pause that is longer than the filters foresee, unless what comes after it
        # is merely late.
        regular = ticks.deviation < REGULAR * period and not (self.proven and self.share < 0.5)
        pause = d > 0 and (near >= FAR or near > FEW_TICKS and age > LONG) and not (
            told and bank is not None and self._goes_on(position, x, unit, bank))
        if pause:
            d = near
            if not (regular or self.proven):
                self._begin_anew()                      # it may be no clock at all
                return self._begin(stamp, position, same)
        if d and same and self._standing:
            # They have stopped for good.
            self._standing = False
            self._time += age * self._ratio
            self._last = stamp
            self._steps = (position, position, 1), (position, position, 1)
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
        agree = abs(step) < 0.1 * period + 5.0 * ticks.deviation
        if pause:
            told = False
            self._readings.clear()
            self._new, agreed = 0, position
        if told:
            self._wrong += 0.05 * ((abs(x - d) > 0.35 and not agree) - self._wrong)
        if agree:
            self._deviation += step
        if not same:
            self._steps = (position, self._position, d), self._steps[0]
            if self._same or self._moved[3] > 0.0:
                self._follow_hold(stamp, position)
            else:
                self._moved = position, self._moved[0], stamp, 0.0
        self._last, self._position = stamp, position
        self._tick += d
        before = ticks.deviation > 0.15 * period        # whether the stamps cannot tell
        if told:
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
            onward = span
            if by_joints and abs(d * unit - x * unit) <= abs(span - x * unit):
                onward = d * unit
        elif told:
            onward = d * unit + self.share * min(max(x - d, -0.2), 0.2) * unit
        else:
            onward = d * unit
        # Late again and again, or early: these are not the ticks. Who catches up is late, less.
        self._contrary = 0 if agree else self._contrary + (
            paced and (step > 0.0 or late < 0.0))
        self._time += max(onward, 0.1 * unit)
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
            replay = self._begin_anew() or replay
        return Placed(self._time, self._time + self._ahead, 1.0 / self._ratio, 0.0, replay)

    def _goes_on(self, position: array[float], x: float, unit: float, bank: Bank) -> bool:
        """Whether a reading after a pause is the next one, late: all joints go on by a tick."""
        d = round(x)
        if not 0 < d < FEW_TICKS:
            return False
        n, state = len(position), bank.state()
        span = d * unit
        move = [span * (state[n + j] + 0.5 * span * state[2 * n + j]) for j in range(n)]
        return dist(position, [state[j] + move[j] for j in range(n)]) < (
            NEXT * hypot(*move) / d)

    # ---- before there are ticks

    def _begin(self, stamp: float, position: array[float], same: bool) -> Placed:
        """Place a message by its stamp."""
        age = stamp - self._last
        if not same:
            self._steps = (position, self._position, 1), self._steps[0]
            self._follow_hold(stamp, position)
        if same and age < 1.3 * self.hold:
            self.held += 1
            return Placed(None, self._time + age * self._ratio, 1.0 / self._ratio, age, None)
        self.fresh += 1
        self._stamps.append(stamp)
        self._time += age * self._ratio
        self._last, self._position = stamp, position
        if len(self._stamps) == FIRST:
            self._first_ticks()
        return Placed(self._time, self._time, 1.0 / self._ratio, 0.0, None)

    def _first_ticks(self) -> None:
        """Take one tick for each stamp, or as many as their steps if these are near multiples."""
        stamps = self._stamps
        steps = sorted(b - a for a, b in zip(stamps, stamps[1:]))
        period = steps[len(steps) // 2]
        pauses = [k for k in range(1, FIRST) if stamps[k] - stamps[k - 1] > PAUSE * period]
        if pauses:
            self._stamps = stamps[pauses[-1]:]
            return
        apart = sorted(abs(step - period) for step in steps)
        numbers = list(map(float, range(FIRST)))
        if apart[len(apart) // 2] < 0.15 * period:
            for k in range(1, FIRST):
                numbers[k] = numbers[k - 1] + max(
                    1.0, round((stamps[k] - stamps[k - 1]) / period))
        line = Line(FIRST)
        last = numbers[-1]
        for number, stamp in zip(numbers, stamps):
            line.add(number - last, stamp)
        phase, period, deviation = line.fit(0.0)
        if deviation > max(LATEST, IRREGULAR * period):
            self._stamps = stamps[FIRST // 2:]
            return
        self.ticks = TickCounter(phase, period, FIRST, max(deviation, 1e-4 * period))
        for number, stamp in zip(numbers, stamps):
            self.ticks.line.add(number - last, stamp)
        self.unit = period * self._ratio

    def _begin_anew(self) -> list[tuple[float, array[float]]] | None:
        """Go by the stamps, since the ticks are not what they were; count anew."""
        readings = self._readings
        count = readings.number()
        stamps = [readings.at(i)[2] for i in range(count)]
        self._ratio = 1.0
        replay = None
        if count >= BLOCK and all(b - a > 1e-5 for a, b in zip(stamps, stamps[1:])):
            replay = [(self._time + stamps[i] - stamps[-1], readings.position(i))
                      for i in range(count)]
        self.ticks = None
        self._stamps = [self._last]
        self.share, self.proven, self._wrong, self._ahead = 1.0, False, 0.0, 0.0
        self._contrary = 0
        self._readings.clear()
        self._squares, self._blocks = [0.0, 0.0, 0.0], 0
        self._rest, self._due, self._patience = 8, 0.0, 1.0
        return replay

    # ---- held readings

    def _stands(self, foreseen: float, bank: Bank) -> bool:
        """
        Whether a reading that repeats cannot be a new one: joints do not stop so fast.

        They had gone on evenly, by many steps of the encoder, up to the last reading.
        """
        gone, before = (dist(new, old) / ticks for new, old, ticks in self._steps)
        return (gone > 0.8 * before > 0.0 and foreseen > 0.5 * gone
                and bank.encoder_steps(self.unit) > STEPS_SEEN)

    def _follow_hold(self, stamp: float, position: array[float]) -> None:
        """Learn for how long readings are held that repeat and then go on as before."""
        moved, before, when, ran = self._moved
        move = [a - b for a, b in zip(position, moved)]
        sizes = [abs(m) for m in move]
        self._quantum = min(self._quantum, min(size for size in sizes if size > 0.0))
        run = stamp - when
        if before is not None and max(sizes) > 4.0 * self._quantum:
            old = [a - b for a, b in zip(moved, before)]
            along = sum(a * b for a, b in zip(move, old))
            both = sqrt(sum(a * a for a in move) * sum(a * a for a in old))
            if along > 0.8 * both and self._same > 0:
                self.hold = max(0.98 * self.hold, min(run, ran))
            else:
                self.hold *= 0.98
        self._moved = position, moved, stamp, run if self._same > 0 else 0.0
        self._same = 0

    # ---- what the joints say

    def _judge(self) -> list[tuple[float, array[float]]] | None:
        """
        Find how much of the stamps' deviation from the ticks makes the positions smoothest.

        The regression of the fourth differences of positions against ticks on those of velocity
        times deviation: 0 for late arrival, 1 for a sampler that wobbles and knows it.
        """
        ticks = self.ticks
        assert ticks is not None
        self._new = 0
        readings = self._readings
        replay = None
        common = readings.divisor(BLOCK)
        if common > 1 and (self.hold > 0.0 or self._told >= BLOCK):
            self._coarsen(common)
        new = readings.regress(BLOCK, ticks.period)
        if not any(new):
            return None
        if ticks.deviation > NOTHING * ticks.period and all(-inf < value < inf for value in new):
            self._blocks += 1
            share = max(0.04, 1.0 / self._blocks)
            self._squares = [old + share * (value - old)
                             for old, value in zip(self._squares, new)]
            cross, of_stamps, of_all = self._squares
            if of_stamps > 0.0:
                best = cross / of_stamps
                left = max(of_all - best * cross, 0.0)
                # Known well enough, by its deviation? A few blocks can tell the extremes only.
                if left < 0.5 * of_stamps * min(self._blocks, 25) and (
                        self._blocks > 4 or best < 0.25 or best > 0.8):
                    few = self._blocks <= 4
                    self.share = (0.0 if best < 0.1 or few and best < 0.25
                                  else 1.0 if best > 0.8 else best)
                    if not self.proven and self.share < 0.5:
                        replay = self._place_again()
                    self.proven = True
        if self._blocks >= 25:
            self._rest = max(8, min(64, int(0.05 / self.unit)))
        elif (self.share == 1.0 and self.hold == 0.0
                and self._last - readings.at(-BLOCK)[2] > 0.06):
            self._rest = 4
        else:
            self._rest = 8
        if self.share > 0.2 and self._blocks >= self._due:
            replay = self._search() or replay
        return replay

    def _place_again(self) -> list[tuple[float, array[float]]] | None:
        """Return the latest readings as they would have been placed by what is known now."""
        readings = self._readings
        assert self.ticks is not None
        tick, deviation, _, _ = readings.at(-1)
        scale = self.share * self.unit / self.ticks.period
        placed = []
        for i in range(readings.number()):
            k, e, _, _ = readings.at(i)
            placed.append((self._time + (k - tick) * self.unit + (e - deviation) * scale,
                           readings.position(i)))
        increasing = all(b[0] - a[0] > 0.05 * self.unit for a, b in zip(placed, placed[1:]))
        return placed if increasing else None

    def _coarsen(self, common: int) -> None:
        """Let ticks be longer: all steps were multiples, of late and long before."""
        ticks = self.ticks
        assert ticks is not None
        others = sum(w for d, w in ticks.often.items() if d % common)
        if others > 1e-3 * ticks.total:
            return
        ticks.coarsen(common)
        self.unit *= common
        self._readings.rescale(self._tick, common)
        self._tick = 0.0

    def _search(self) -> list[tuple[float, array[float]]] | None:
        """Try other countings of the latest readings; adopt one that is proven."""
        ticks, readings = self.ticks, self._readings
        assert ticks is not None
        number = self._periods.since_moving()
        if number < BLOCK:
            return None
        if number >= 30:        # a long window that tells nothing
            self._due = self._blocks + self._patience
            self._patience = min(1.5 * self._patience, 40.0)
        readings.drop(readings.number() - number)
        found = self._periods.search(ticks.deviation, ticks.period)
        if found is None or found[0] < ADOPT:
            return None
        _, numbers, at_zero, period, deviation = found
        last = numbers[-1]
        phase = at_zero + period * last
        line_period = period
        known = (abs(period - ticks.period) < 10.0 * deviation / max(last, 1.0) / sqrt(number)
                 and ticks.count > 2 * number and last == number - 1)
        if known:               # the longer memory knows better
            period, phase = ticks.period, ticks.phase
        new = TickCounter(phase, period, max(ticks.count, number) if known else number, deviation)
        for a, b in zip(numbers, numbers[1:]):
            new.note(int(b - a))
        if known:
            new.go_on_as(ticks)
        else:
            for i, k in enumerate(numbers):
                new.line.add(k - last, readings.at(i)[2])
        self.ticks, self.unit, self._ratio = new, period, 1.0
        self.share, self.proven, self._wrong, self._foreseen = 0.0, True, 0.0, None
        self._tick, self._ahead = last, self._last - phase
        replay = []
        for i, k in enumerate(numbers):
            e = readings.at(i)[2] - (at_zero + line_period * k)
            time = self._time + (k - last) * period
            readings.place(i, k, e, time)
            replay.append((time, readings.position(i)))
            self._deviation = e
        self._squares, self._blocks, self._rest, self._due = [0.0, 0.0, 0.0], 0, 8, 0.0
        return replay

    # ---- what it has found

    def doubts(self) -> Sequence[str]:
        """Return what the clock has found, if the stamps are not when joints were read."""
        ticks = self.ticks
        if ticks is None or self.fresh < FEW or self.share > 0.5 or not self.proven:
            return [] if not self.held else [
                f'{self.held} of {self.held + self.fresh} messages repeat a reading while the '
                'joints move']
        period = ticks.period
        held, lost = self.held / (self.fresh + self.held), self.lost / (self.fresh + self.lost)
        if max(held, lost) < 0.01:
            if ticks.deviation < WORTH_TELLING:
                return []
            return [f'stamps jitter by {1e3 * ticks.deviation:.2g} ms: replaced by a regular '
                    f'clock of {1.0 / period:.1f} Hz']
        found = (f'read by another clock: device at {1.0 / period:.1f} Hz, readings '
                 f'{2e3 * ticks.early:.1f} ms old on average')
        if held > 0.01:
            found += f', {100.0 * held:.0f} % held'
        if lost > 0.01:
            found += f', {100.0 * lost:.0f} % skipped'
        return [found]

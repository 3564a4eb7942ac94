# cython: annotation_typing=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""When each reading was taken, in the time of the device that took it."""
from __future__ import annotations

from collections.abc import Sequence
from math import inf

from .clock_error import ClockError
from .clock_findings import clock_doubts, clock_error, HOLDS, Tally
from .first_ticks import FIRST, FirstTicks
from .foresight import Foreseen, Foresight
from .held_readings import HeldReadings
from .joint_evidence import BLOCK, JointEvidence, Recount, Replay
from .numbers import Row
from .tick_counter import TickCounter, Ticks
from ..core.bank import Bank

JITTER = 0.08
"""Mean deviation of the first stamps from a line, in periods, from which on ticks are believed
until the joints say otherwise."""

MANY, STRETCH = 40, 0.5
"""Messages from which on it is known how far they are apart; and after how long, s, that is
measured anew: where many were lost at first, they seemed further apart."""

TOLD = 0.25
"""Ticks by which joints may be from where they are foreseen once they have told the ticks."""

NO_TICKS = 0.25
"""Deviation of stamps from their ticks, in periods, from which on there are none: it is as large
where stamps are anywhere between."""

VOTE = 0.3
"""What a message weighs in the share of those whose joints contradict the count and went as far as
the stamps say; where that is above a half the stamps are believed."""

REGULAR = 0.05
"""Deviation of stamps from their ticks, in periods, up to which they are right about a pause."""

NOTHING = 2e-3
"""Deviation of stamps from their ticks, in periods, up to which it does not matter."""


class Placed:
    """Where a message is in the device's time."""

    def __init__(self, time: float | None, instant: float, rate: float, age: float,
                 replay: list[tuple[float, Row]] | None, anew: bool = False) -> None:
        self.time = time          # when its reading was taken, s; None: it was there before
        self.instant = instant    # the device's time at the message's stamp, s
        self.rate = rate          # seconds of the stamps' clock in a second of the device's
        self.age = age            # from when the latest reading was first sent to the stamp, s
        self.replay = replay      # latest readings and their times, where these are others now
        self.anew = anew          # whether nothing is known of the motion: a run begins


class DeviceClock:
    """
    The clock of the device that reads the joints, from stamps and positions.

    A device reads at regular ticks; messages repeat, skip, delay and mis-stamp the readings. For
    each message it is *counted* how many ticks passed since the last reading (`TickCounter`); the
    reading is *placed*: device time goes on by whole ticks, and by that share of the stamp's
    deviation which is true (a sampler that wobbles and knows it, not late arrival); the message's
    stamp is *mapped* to device time by the line through ticks and stamps. The *period* begins as
    that of the messages; other countings are tried while the joints move.
    """

    def __init__(self, n_joints: int) -> None:
        self._evidence = JointEvidence(n_joints)
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
        self._foresight = Foresight()
        self._evidence.start(None if known is None or known.ticks is None else known._evidence)
        # The latest reading: its stamp, its device time, how much later the stamp is by that.
        self._last, self._time, self._ahead, self._position = stamp, stamp, 0.0, position
        # Device time in a second of the stamps' clock; by how much the latest stamp is odd.
        self._ratio, self._doubt = 1.0, 0.0
        # Messages: stamp of the latest, how many, how far apart; stamp of the first of the present
        # stretch, how many were before it.
        self._heard, self._messages, self._spacing = stamp, 0.0, 0.0
        self._first, self._before = stamp, 0.0
        # How often joints told ticks, how often otherwise than counted, of late; and the stamps,
        # in a row; whether ticks were lost that these could not tell.
        self._told, self._wrong, self._contrary, self._lossy = 0, 0.0, 0, False
        # How often, of late, joints that contradicted the count went as far as the stamps say.
        self._true = 0.0
        if known is not None and known.ticks is not None:
            self.ticks = known.ticks.fresh(stamp)
            self.unit = self.ticks.period
            self.share, self.proven = known.share, True
            self._lossy, self._foresight = known._lossy, Foresight(known._foresight.usual)
            self._repeated = HeldReadings(stamp, position, known._repeated.hold,
                                          known._repeated.quantum)

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
        Place a message, whose stamp, s, is later than that of the one before.

        The bank foresees the positions; None while it has not settled.
        """
        same = position == self._position
        self._hear(stamp)
        ticks = self.ticks
        if ticks is None:
            return self._begin(stamp, position, same)
        near = round((stamp - ticks.phase) / ticks.period)
        foreseen = Foreseen(position, near) if bank is None else self._foresight.foresee(
            position, near, self.unit, bank)
        d = self._count(ticks, stamp, same, foreseen, bank)
        if d == 0:
            return self._hold(ticks, stamp)
        regular = self._regular(ticks)
        pause = self._pauses(ticks, stamp, foreseen) and not (
            bank is not None and foreseen.told and foreseen.goes_on(position, self.unit, bank))
        if pause and not (regular or self.proven):
            self.begin_anew()                           # it may be no clock at all
            return self._begin(stamp, position, same, True)
        if pause:
            d, foreseen = near, Foreseen(position, near)
        if same and self._repeated.standing:
            return self._stand(ticks, stamp, position, d)
        self.fresh += 1
        if pause:
            self._evidence.pause()
            if ticks.vague():
                ticks.begin_line()      # which ticks these were nobody tells
        else:
            self.lost += d - 1
            if bank is not None and not same:
                self._foresight.learn(foreseen, d)
        self._place(ticks, stamp, position, same, d, regular or pause, foreseen)
        replay = None if same else self._ask_joints()
        if self._wrong > 0.4 or self._contrary > 2 or (
                self.ticks is ticks and ticks.sets > 3.0 and abs(ticks.lean) > 0.8):
            replay = self.begin_anew() or replay
        return Placed(self._time, self._time + self._ahead, 1.0 / self._ratio, 0.0, replay)

    def _hear(self, stamp: float) -> None:
        """Follow how far messages are apart."""
        # Also those that did not come: a pause does not make the others come slower.
        steps = (stamp - self._heard) / self._spacing if self._messages > 4.0 else 1.0
        self._messages += round(steps) if steps > (1.5 if self._messages > MANY else 4.0) else 1
        self._heard = stamp
        since, messages = stamp - self._first, self._messages - self._before
        over = since > STRETCH and messages > MANY
        if over or self._before == 0.0:
            self._spacing = since / messages
        if over:
            self._first, self._before = stamp, self._messages

    # ---- before there are ticks

    def _begin(self, stamp: float, position: Row, same: bool, anew: bool = False) -> Placed:
        """Place a message by its stamp, before there are ticks; `anew`: after a pause."""
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
            self._evidence.add(stamp, self._time, position)
        self.ticks = ticks = self._begun.add(stamp)
        if ticks is not None:
            self.unit = ticks.period * self._ratio
            self._evidence.count_first(ticks, stamp)
        # What the filters knew was of another time, if it was no clock.
        return Placed(self._time, self._time, 1.0 / self._ratio, 0.0,
                      [(self._time, position)] if anew else None, anew)

    def begin_anew(self) -> Replay | None:
        """Go by the stamps, since the ticks are not what they were; count anew."""
        replay = self._evidence.by_stamps(self._time)
        self._ratio = 1.0
        self.ticks, self._begun = None, FirstTicks(self._last)
        self.share, self.proven, self._wrong, self._ahead = 1.0, False, 0.0, 0.0
        self._contrary = 0
        self._evidence.forget()
        return replay

    # ---- counted: how many ticks have passed

    def _count(self, ticks: TickCounter, stamp: float, same: bool, foreseen: Foreseen,
               bank: Bank | None) -> Ticks:
        """Return how many ticks passed since the latest reading; 0: this is the same one."""
        age, repeats = stamp - self._last, inf
        if same and self._repeated.repeats(stamp, age, foreseen.length, self.unit, bank):
            return 0
        if same and age < 3.5 * ticks.period:
            repeats = 0.0 if bank is None else bank.odds_against_repeating(self.unit)
        return ticks.number(stamp, foreseen.ticks, foreseen.deviation, foreseen.surprise, repeats)

    def _regular(self, ticks: TickCounter) -> bool:
        """Whether stamps are right about a loss: regular, and not proven to be another clock's."""
        return ticks.deviation < REGULAR * ticks.period and not (
            self.proven and self.share < 0.5)

    def _pauses(self, ticks: TickCounter, stamp: float, foreseen: Foreseen) -> bool:
        """Whether no reading came for longer than the filters foresee: all stamps tell that."""
        age = stamp - self._last
        # One that is late already was none, so its time has passed since the last message.
        return foreseen.far(age) and 2.0 * age > foreseen.near * ticks.period

    def _hold(self, ticks: TickCounter, stamp: float) -> Placed:
        """Map a message that repeats the latest reading."""
        age = stamp - self._last
        self.held += 1
        ticks.note(0)
        return Placed(None, self._time + self._ahead + age * self._ratio, 1.0 / self._ratio, age,
                      None)

    def _stand(self, ticks: TickCounter, stamp: float, position: Row, d: Ticks) -> Placed:
        """Place a reading of joints that have stopped: the filters begin anew, at rest."""
        self._repeated.stopped(position)
        self._time += (stamp - self._last) * self._ratio
        self._last = stamp
        ticks.advance(d, stamp, False)
        self._evidence.advance(d, 0.0)
        return Placed(self._time, self._time, 1.0 / self._ratio, 0.0, [(self._time, position)])

    # ---- placed and mapped: a new reading in the device's time, and its stamp

    def _place(self, ticks: TickCounter, stamp: float, position: Row, same: bool, d: Ticks,
               by_stamps: bool, foreseen: Foreseen) -> None:
        """
        Let device time go on to a new reading, and map its stamp.

        `by_stamps`: whether these are right about a loss or a pause.
        """
        period, unit = ticks.period, self.unit
        age = stamp - self._last
        step, span = age - d * period, age * self._ratio
        most = 0.1 * period + 5.0 * ticks.deviation
        # Else the stamp was set, or is late: the count alone.
        agree = abs(step) < most and (
            self.share == 1.0 or abs(stamp - ticks.phase - d * period) < most)
        if self.share < 1.0:
            self._ratio = unit / period                 # stamps alone need none
        if not agree and foreseen.contradicts(d):
            right = abs(foreseen.ticks * unit - span) < abs(foreseen.ticks - d) * unit
            self._true += VOTE * (right - self._true)
        if agree:
            onward = span if self.share == 1.0 else d * unit + self.share * step * self._ratio
        elif by_stamps and self.share > 0.5 or self._true > 0.5 or (
                self.share == 1.0 and self.proven and foreseen.told):
            onward = foreseen.nearer(d, span, unit)
            agree = self._true > 0.5 and onward == span
        else:
            onward = d * unit
            if foreseen.told:
                onward += self.share * min(max(foreseen.ticks - d, -0.2), 0.2) * unit
        self._time += max(onward, 0.1 * unit)
        if not same:
            self._repeated.moved(stamp, position, d, False)
        self._last, self._position = stamp, position
        late = self._advance(ticks, stamp, d, agree, foreseen)
        # Late again and again, or early: these are not the ticks. Who catches up is late, less.
        self._contrary = 0 if agree else self._contrary + (
            by_stamps and (step > 0.0 or late < 0.0))
        # The stamp is mapped: it is late, unless that is true of the reading.
        off = abs(late) if ticks.deviation < REGULAR * period else 0.0
        self._doubt = off if off > most else 0.0        # or the clock was set
        self._ahead = late * (1.0 - self.share * agree) * self._ratio
        self._evidence.advance(d, step if agree else 0.0)
        if not same:
            self._evidence.add(stamp, self._time, foreseen.agreed_on(position, d))
        if not self.proven and ticks.count == 2 * FIRST and ticks.deviation > JITTER * period:
            self.share = 0.0

    def _advance(self, ticks: TickCounter, stamp: float, d: Ticks, agree: bool,
                 foreseen: Foreseen) -> float:
        """Let the counter go on; return by how much the stamp is later than the tick, s."""
        vague = ticks.vague()
        if foreseen.told:
            self._wrong += 0.05 * ((foreseen.contradicts(d) and not agree) - self._wrong)
            self._told += 1
            if d > 1 and vague and not self._lossy:
                # Some were lost, unseen while the joints rested.
                self._lossy = True
                ticks.forget(self._told)
        return ticks.advance(d, stamp, foreseen.told or not (vague and self._lossy))

    # ---- what the joints say

    def _ask_joints(self) -> Replay | None:
        """Let the latest readings tell how much of the stamps is true, and of which ticks."""
        evidence = self._evidence
        if not evidence.due():
            return None
        ticks, held = self.ticks, self._repeated.hold > 0.0
        assert ticks is not None
        if held or self._told >= BLOCK:
            self.unit *= evidence.coarsen(ticks)
        regression = evidence.regress(ticks.period)
        if not any(regression):
            return None
        replay = None
        if ticks.deviation > NOTHING * ticks.period:
            share = evidence.share(regression)
            if share is not None:
                whole = self._true > 0.5 or share > 0.5 and (
                    ticks.deviation > NO_TICKS * ticks.period)
                self.share = 1.0 if whole else share
                if not self.proven and share < 0.5:
                    replay = self._recount() or evidence.by_ticks(
                        self.unit, share * self.unit / ticks.period)
                self.proven = True
        searching = evidence.wait(self.unit, self.share == 1.0 and not held)
        if self.share > 0.2 and searching:
            replay = self._recount() or replay
        return replay

    def _recount(self) -> Replay | None:
        """Go by other ticks, if the joints have told these from the present ones."""
        assert self.ticks is not None
        found: Recount | None = self._evidence.search(self.ticks, self._repeated.quantum)
        if found is None:
            return None
        self.ticks = ticks = found.ticks
        self.unit, self._ratio = ticks.period, 1.0
        self.share, self.proven, self._wrong = 0.0, True, 0.0
        self._ahead = self._last - ticks.phase
        self._foresight.usual = TOLD * found.move
        # The other messages repeated readings.
        for _ in range(round((self._last - found.first) / self._spacing)
                       - len(found.replay) + 1):
            ticks.note(0)
        return found.replay

    # ---- what it has found

    def doubts(self) -> Sequence[str]:
        """Return what the clock has found, if the stamps are not when joints were read."""
        return clock_doubts(
            self.ticks if self.proven and self.share <= 0.5 else None, self._tally())

    def _tally(self) -> Tally:
        return Tally(self.held, self.fresh, self.lost)

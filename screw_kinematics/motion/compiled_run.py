# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A steady run of samples in machine code: one call for each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from struct import error as PackError, Struct
from typing import Any, NamedTuple

import numpy as np

from . import run_memory as at, steady_steps
from .compiled import Kernels
from .filter_bank import FilterBank
from .filter_step import SteadyGains, Step
from .fixed_lag import carry_back, FixedLag, Taps
from .guard import SampleGuard
from .joint_motion import Array
from .pace import Pace
from .sampling_clock import SamplingClock, WINDOW
from .steady_steps import Numbers, Snapshot
from .velocity_block import NEIGHBOURS
from .velocity_trust import LONGEST_BLOCK, VelocityTrust

TRUST_SAMPLES = at.TRUST_STAMPS, at.TRUST_POSITIONS, at.TRUST_VELOCITIES
"""Blocks of the samples whose velocities are to be judged."""


class Parts(NamedTuple):
    """What an estimator consists of."""

    guard: SampleGuard
    pace: Pace
    clock: SamplingClock | None
    trust: VelocityTrust | None
    bank: FilterBank
    lag: FixedLag | None


class Left(NamedTuple):
    """How an estimator's run stands when it goes on with its parts."""

    instant: float
    """Stamp that was used for the latest sample, s."""

    taken: int
    """Samples taken meanwhile."""

    state: Array
    """Latest estimate, shape (4, n)."""

    snapshot: Snapshot
    """What its covariance follows from."""


class CompiledRun:
    """
    Takes samples in place of an estimator's parts while nothing is out of the ordinary.

    It has the same numbers as these, and does the same with them: `enter` takes the numbers over
    when the run of samples has become steady, `leave` gives them back.

    Parameters
    ----------
    kernels:
        The compiled functions.
    parts:
        The parts it works for.
    delay:
        Estimates describe the instant this long before the latest sample, s.

    """

    def __init__(self, kernels: Kernels, parts: Parts, delay: float) -> None:
        self.active = False
        self._kernels = kernels
        self._parts = parts
        self._delay = delay
        self._gains: SteadyGains | None = None
        n = parts.bank.n_joints
        self._without, self._with = Struct(f'{2 + n}d'), Struct(f'{2 + 2 * n}d')
        self._values = Struct(f'{4 * n}d')

    def enter(self, instant: float) -> bool:
        """
        Take over if the run is steady; return whether it is.

        Parameters
        ----------
        instant:
            Stamp that was used for the latest sample, s.

        """
        _, pace, clock, trust, bank, lag = self._parts
        gains = bank.steady
        if (gains is None or gains.reference != pace.reference
                or gains.ratio is not (None if trust is None else trust.ratio)):
            return False
        numbers, taps = bank.numbers, None if lag is None else lag.taps
        if numbers is None or not (
                (clock is None or clock.locked) and (lag is None or taps is not None)):
            return False
        if gains is not self._gains:
            self._prepare(gains, taps)
        self._load(instant, numbers)
        self.active = True
        return True

    @property
    def instant(self) -> float:
        """Stamp that was used for the latest sample, s."""
        return self._cells[at.STATE + at.INSTANT]

    @property
    def onward(self) -> float:
        """How far the estimate lies after the sample that it starts from, s."""
        return self._cells[at.ONWARD]  # type: ignore[no-any-return]

    def take(self, stamp: float, position: Any, velocity: Any) -> bool:
        """
        Take a sample; return whether there is an estimate.

        If not, nothing has changed, and it is for the estimator's parts to take the sample.
        """
        memory = self._array
        try:
            if velocity is None:
                self._without.pack_into(memory, self._inbox, 0.0, stamp, *position)
            else:
                self._with.pack_into(memory, self._inbox, 1.0, stamp, *position, *velocity)
        except (PackError, TypeError):      # not numbers, or not as many as there are joints
            return False
        return self._kernels.take(memory)  # type: ignore[no-any-return]

    def values(self) -> Sequence[float]:
        """Return positions, velocities, accelerations and jerks of the estimate in a row."""
        return self._values.unpack_from(self._cells, self._outbox)

    def state(self) -> Array:
        """Return the estimate, shape (4, n)."""
        return self._memory[at.OUTBOX].copy()

    def snapshot(self) -> Snapshot:
        """Return what `MotionEstimator` finds the covariance from, as it is now."""
        filters = self._memory[at.FILTERS].copy().T
        weights, noise, x, p = filters[6], filters[4], filters[:4], self._parts.bank.p
        if not self._delay:
            return lambda: (weights, noise, x, p)
        gains, taps = self._gains, self._taps
        assert gains is not None and taps is not None
        memory, channels = self._memory, 1 if gains.step.velocity is None else 2
        slots, errors = self._slots(), self._innovations()[:channels].copy()
        stamps, oldest = memory[at.LAG_STAMPS].copy(), memory[at.LAG_STATES][slots[0]].copy()

        def smoothed() -> tuple[Array, Array, Array, Array]:
            states = [oldest] * len(slots)      # only the first is looked at
            x, _ = carry_back(_steps(gains, stamps[slots], states, errors), covariance=False)
            return weights, noise, x, taps.covariance(len(slots))

        return smoothed

    def leave(self) -> Left:
        """Give the numbers back."""
        self.active = False
        guard, pace, clock, trust, bank, lag = self._parts
        memory, gains, before = self._memory, self._gains, bank.numbers
        state = memory.state
        assert gains is not None and before is not None
        taken, instant = int(state[at.TAKEN]), float(state[at.INSTANT])
        left = Left(instant, taken, self.state(), self.snapshot())
        guard.run = float(state[at.STAMP]), float(state[at.SHORTEST]), memory[at.LAST].copy()
        pace.state = state[at.PACE:].tolist()
        if clock is not None:
            clock.state = state[at.CLOCK:at.PACE].tolist()
            end = int(state[at.CLOCK_END])
            stamps = memory[at.CLOCK_STAMPS][end - WINDOW:end].tolist()
            positions = memory[at.CLOCK_POSITIONS][end - WINDOW:end].copy()
            clock.samples.extend((given, tick, q) for (given, tick), q in zip(stamps, positions))
        if trust is not None:
            end = int(state[at.TRUST_END])
            stamps, positions, rates = (memory[which][:end].copy() for which in TRUST_SAMPLES)
            trust.run = (stamps.tolist(), list(positions), list(rates),
                         float(state[at.TRUST_JUDGED]), int(state[at.TRUST_JUDGEMENTS]))
            trust.known = memory[at.TRUST_KNOWN].copy()
        if lag is not None:
            slots = self._slots()
            lag.resume(_steps(gains, memory[at.LAG_STAMPS][slots], memory[at.LAG_STATES][slots],
                              self._innovations().copy()), gains)
        x = np.ascontiguousarray(memory[at.FILTERS].T)
        bank.numbers = Numbers(before.steps + taken, x[:4], x[4], x[5], x[6],
                               float(state[at.SPAN]), float(state[at.UNWEIGHED]))
        return left

    def _prepare(self, gains: SteadyGains, taps: Taps | None) -> None:
        """Make room for a run with these gains, and write down what stays as it is."""
        self._gains, self._taps = gains, taps
        _, m, n = gains.table.shape
        length, sets = (0, 0) if taps is None else (taps.length, taps.position.shape[3])
        self._memory = memory = at.RunMemory(
            n, m, length, sets, 4 * WINDOW, NEIGHBOURS + LONGEST_BLOCK + 1)
        self._array: Any = memory.array
        self._cells = memory.cells
        self._inbox, self._outbox = memory.place(at.INBOX), memory.place(at.OUTBOX)
        guard, _, clock, trust, bank, _ = self._parts
        wraps = guard.wraps
        memory[at.WRAPS][:] = 0.0 if wraps is None else wraps
        for setting, value in (
                (at.N, n), (at.M, m), (at.CONTINUOUS, wraps is not None),
                (at.MAX_GAP, guard.max_gap), (at.MAX_VELOCITY, guard.max_velocity),
                (at.MAX_JUMP, guard.max_jump), (at.CLOCKED, clock is not None),
                (at.TRUSTING, trust is not None), (at.RATED, gains.step.velocity is not None),
                (at.REFERENCE, gains.reference), (at.WINDOW, bank.window),
                (at.RENEWAL, steady_steps.REWEIGH), (at.DELAY, self._delay),
                (at.LENGTH, length), (at.TAP_SETS, sets)):
            memory.array[setting] = value
        table = memory[at.GAINS].T
        table[:4], table[8:10] = gains.table[:4], gains.table[4:]
        if gains.step.velocity is not None:
            table[4:8], table[10:] = gains.velocity_table[:4], gains.velocity_table[4:]
        if taps is not None:
            for c, of_channel in enumerate((taps.position, taps.velocity)):
                if of_channel is not None:
                    memory[at.LAG_TAPS][c] = of_channel.transpose(3, 0, 2, 1)

    def _load(self, instant: float, numbers: Numbers) -> None:
        """Write down how the run stands."""
        guard, pace, clock, trust, _, lag = self._parts
        memory = self._memory
        state = memory.state
        state[:] = 0.0
        state[at.STAMP], state[at.SHORTEST], memory[at.LAST][:] = guard.run
        state[at.INSTANT] = instant
        state[at.PACE:] = pace.state
        if clock is not None:
            state[at.CLOCK:at.PACE] = clock.state
            state[at.CLOCK_END] = WINDOW
            for k, (given, tick, position) in enumerate(clock.samples):
                memory[at.CLOCK_STAMPS][k] = given, tick
                memory[at.CLOCK_POSITIONS][k] = position
        if trust is not None:
            samples: list[Any]
            *samples, state[at.TRUST_JUDGED], state[at.TRUST_JUDGEMENTS] = trust.run
            state[at.TRUST_END] = end = len(samples[0])
            memory[at.TRUST_KNOWN][:] = trust.known
            if end:
                for which, rows in zip(TRUST_SAMPLES, samples):
                    memory[which][:end] = rows
        x = memory[at.FILTERS].T
        x[:4], x[4], x[5], x[6] = (
            numbers.x, numbers.noise, numbers.velocity_noise, numbers.weights)
        state[at.SPAN], state[at.UNWEIGHED] = numbers.span, numbers.unweighed_time
        if lag is not None:
            steps = lag.steps
            errors = memory[at.LAG_ERRORS]
            for k, (stamp, step) in enumerate(steps):
                memory[at.LAG_STAMPS][k] = stamp
                memory[at.LAG_STATES][k] = step.state.T
                errors[0, ..., k] = step.position.error.T
                if step.velocity is not None:
                    errors[1, ..., k] = step.velocity.error.T
            state[at.LAG_HEAD], state[at.LAG_COUNT] = len(steps) - 1, len(steps)
            state[at.LAG_END] = len(steps)

    def _slots(self) -> list[int]:
        """Return the places of the samples since the delayed instant in their rings."""
        cells, ring = self._cells, len(self._memory[at.LAG_STAMPS])
        head = int(cells[at.STATE + at.LAG_HEAD])
        count = int(cells[at.STATE + at.LAG_COUNT])
        return [k % ring for k in range(head - count + 1, head + 1)]

    def _innovations(self) -> Array:
        """Return the innovations since the delayed instant, shape (2, n, M, length)."""
        end, count = (int(self._cells[at.STATE + i]) for i in (at.LAG_END, at.LAG_COUNT))
        return self._memory[at.LAG_ERRORS][..., end - count:end]


def _steps(
    gains: SteadyGains, stamps: Array, states: Iterable[Array], errors: Array
) -> list[tuple[float, Step]]:
    """
    Return steps with these gains.

    Parameters
    ----------
    gains:
        The gains.
    stamps: shape (N,)
        Their stamps, s.
    states: N of shape (n, M, 4)
        Predicted states.
    errors: shape (2, n, M, N) or (1, n, M, N)
        Innovations of position and, if the gains use it, velocity.

    """
    spans = np.diff(stamps, prepend=stamps[0] - gains.reference)
    return [(stamp, gains.repeated(dt, state.T, e[..., 0], e[..., -1])) for stamp, dt, state, e in
            zip(stamps.tolist(), spans.tolist(), states, errors.T)]

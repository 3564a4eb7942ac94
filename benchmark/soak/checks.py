# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every output of a topic, checked against what is true at its stamp."""
from dataclasses import dataclass

import numpy as np

from .robots import BASES, RIVAL_NS, SAMPLES, SoakRobot, TICK_NS
from .shared import Progress, RING
from .tail import Runs
from .tally import Collector, decode, Latencies, Tally as CommonTally

EXACT = 1e-9
"""Greatest error of what follows from one sample [rad/s, m/s]."""

ESTIMATED = {'twist': 1e-3, 'accel': 0.05}
"""The same for estimates, in parts of the quantity's root mean square."""

STAMP_NS = 100_000
"""How far from a sample's stamp an output's may be."""


@dataclass
class Tally(CommonTally):
    """What was found about the outputs of a topic, exact ones and estimates."""

    exact: int = 0          # compared with the truth, by the bound of the exact ones
    estimated: int = 0      # the same by that of estimates
    unsettled: int = 0      # estimates within or soon after a fault, not compared
    wrong: int = 0          # not what follows from the sample
    too_far: int = 0        # estimates too far from the truth
    worst_exact: float = 0.0
    worst_estimate: float = 0.0

    @property
    def failures(self) -> int:
        """Return how many outputs were not right."""
        return self.not_finite + self.wrong + self.too_far


@dataclass
class Permitted:
    """Which samples there are at present."""

    rival: bool = False         # whether a second publisher has another motion
    unstamped: bool = False     # whether the node stamps some, all of them the motion's first
    settled_from: list[int] | None = None    # for each robot: tick from which estimates are good
    killed_at: list[int] | None = None       # the same: next tick of a source that was killed


class TopicCheck(Collector):
    """Collects the messages of a robot's topic and checks them; samples are a step apart."""

    def __init__(self, number: int, robot: SoakRobot, output: str, progress: Progress,
                 step: int = 1) -> None:
        super().__init__()
        self.tally = Tally()
        self.step = step
        self.runs = Runs(step)      # of samples, since the books were closed
        self.latencies = Latencies()        # of settled outputs
        self.worst_in_faults = 0.0
        self.last_base = 0
        self._number, self._robot, self._output = number, robot, output
        self._exact = output in robot.exact
        self._truth = np.stack([
            robot.expected(description)[output] for description in range(1 + robot.described)])
        self._rival = np.stack([
            robot.expected(description, rival=True)[output]
            for description in range(1 + robot.described)]) if self._exact else self._truth
        # Angular and linear parts have their own size.
        self._size = np.sqrt((self._truth[0].reshape(-1, 2, 3)**2).sum(2).mean(0)).repeat(3)
        self._numbers, self._times = progress.numbers, progress.times(number)

    def check(self, permitted: Permitted) -> None:
        """Check what was collected."""
        batch, arrivals = self.taken()
        if not batch:
            return
        tally = self.tally
        tally.received += len(batch)
        stamps, bases, values, _ = decode(batch)
        finite = np.isfinite(values).all(1)
        self._note('not_finite', ~finite, stamps, values)
        ticks = np.rint(stamps / TICK_NS).astype(int)
        self.runs.take(ticks + self._robot.delay_ticks)
        base = np.array([BASES.index(b) if b in BASES else 0 for b in bases])
        if not self._robot.described:
            base[:] = 0
        self.last_base = int(base[-1])
        settled: np.ndarray = np.zeros(len(batch), bool)
        if permitted.settled_from is not None:
            settled = ticks >= permitted.settled_from[self._number]
        if self._exact:
            self._check_exact(stamps, ticks, base, values, permitted)
        else:
            self._check_estimates(stamps, ticks, values, settled)
        if not permitted.unstamped:
            self._time(ticks, arrivals, settled)

    def _check_exact(self, stamps: np.ndarray, ticks: np.ndarray, base: np.ndarray,
                     values: np.ndarray, permitted: Permitted) -> None:
        def errors(truth: np.ndarray, beside: int | None) -> np.ndarray:
            error = np.abs(values - truth).max(1)
            if beside is not None:
                off = (stamps - beside + TICK_NS // 2) % TICK_NS - TICK_NS // 2
                error = np.where(np.abs(off) <= STAMP_NS, error, np.inf)
            return np.where(np.isfinite(error), error, np.inf)

        error = errors(self._truth[base, ticks % SAMPLES], 0)
        if permitted.rival:
            at = np.rint((stamps - RIVAL_NS) / TICK_NS).astype(int) % SAMPLES
            error = np.minimum(error, errors(self._rival[base, at], RIVAL_NS))
        if permitted.unstamped:
            error = np.minimum(error, errors(self._truth[base, 0], None))
        tally = self.tally
        tally.exact += len(error)
        self._note('wrong', error > EXACT, stamps, values)
        right = error[error <= EXACT]
        tally.worst_exact = max(tally.worst_exact, right.max(initial=0.0))

    def _check_estimates(self, stamps: np.ndarray, ticks: np.ndarray, values: np.ndarray,
                         settled: np.ndarray) -> None:
        tally = self.tally
        tally.unsettled += int((~settled).sum())
        tally.estimated += int(settled.sum())
        error = (np.abs(values - self._truth[0, ticks % SAMPLES])
                 / np.where(self._size > 0, self._size, 1.0)).max(1)
        error = np.where(np.isfinite(error) & settled, error, 0.0)
        self._note('too_far', error > ESTIMATED[self._output], stamps, values)
        tally.worst_estimate = max(tally.worst_estimate, error.max(initial=0.0))

    def _time(self, ticks: np.ndarray, arrivals: np.ndarray, settled: np.ndarray) -> None:
        ring = self._numbers[self._times:self._times + RING]
        published = np.asarray(ring)[(ticks + self._robot.delay_ticks) % RING]
        latency = (arrivals - published) * 1e-9
        # A tick that was never published finds the time of one a whole ring before.
        known = latency < RING * TICK_NS * 1e-9
        latency, settled = latency[known], settled[known]
        self.worst_in_faults = max(self.worst_in_faults, latency.max(initial=0.0))
        self.latencies.add(latency[settled])

    def _note(self, what: str, bad: np.ndarray, stamps: np.ndarray, values: np.ndarray) -> None:
        i = int(np.argmax(bad))
        self.tally.note(what, bad, f'{self._robot.name}/{self._output} {what}: '
                        f'stamp {stamps[i]}, {values[i].tolist()}')

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every output of a topic, against what was true at its stamp, by the deviation it states."""
from dataclasses import dataclass

import numpy as np

from .log import LENGTH, SentLog
from .robots import BASES, FieldRobot, RATE, SAMPLES
from ..tally import Collector, decode, Latencies, Tally as CommonTally

FARTHEST = 10.0
"""Most of its own stated deviation that an output may be wrong by."""

FLOOR = 1e-9
"""Rounding, which no deviation states [rad/s, m/s, and per s]."""

SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Of a driver's mean latency, by which the outputs of a batch may all be early."""


class Sent:
    """The messages of the robot of a number by their stamps."""

    def __init__(self, log: SentLog, number: int) -> None:
        self._entries, self._counts = log.entries[number], log.counts[number]
        self._seen = 0
        self._known: dict[int, tuple[float, int]] = {}

    def update(self) -> None:
        """See what was sent since the last time."""
        count = int(self._counts[1])
        first = max(self._seen, count - LENGTH + 1)
        rows = self._entries[np.arange(first, count) % LENGTH]
        self._known.update(zip(rows['stamp'].tolist(), zip(
            rows['instant'].tolist(), rows['sent'].tolist())))
        self._seen = count
        while len(self._known) > LENGTH:
            del self._known[next(iter(self._known))]

    def find(self, stamps: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return for each stamp if a message had it, its instant [s], and when it was sent."""
        found = [self._known.get(stamp, (np.nan, 0)) for stamp in stamps]
        instants = np.array([instant for instant, _ in found])
        return np.isfinite(instants), instants, np.array([sent for _, sent in found])


@dataclass
class Tally(CommonTally):
    """What was found about the outputs of a topic, errors in the deviations that they state."""

    judged: int = 0         # that state a deviation; the others say that they know none
    strange: int = 0        # with a stamp that no message had
    beyond: int = 0         # wrong by more than ten deviations
    worst: float = 0.0      # greatest error
    squares: float = 0.0    # sum of the squared errors

    @property
    def usual(self) -> float:
        """Return the root mean square of the errors, which ought to be 1 or less."""
        return float(np.sqrt(self.squares / self.judged)) if self.judged else 0.0

    @property
    def failures(self) -> int:
        """Return how many outputs were not right."""
        return self.strange + self.not_finite + self.beyond


def errors(robot: FieldRobot, output: str, t: np.ndarray, values: np.ndarray,
           deviations: np.ndarray, model: int) -> np.ndarray:
    """Return the errors at instants in their deviations, a row for each share of the latency."""
    late, period = robot.latency, SAMPLES / RATE
    truth = robot.truth(t % period, model)[output]
    early = robot.truth((t - late) % period, model)[output] if late else truth
    shares = SHARES if late else SHARES[:1]
    return np.array([(np.abs(values - truth - share * (early - truth))
                      / (deviations + FLOOR)).max(1) for share in shares])


class TopicCheck(Collector):
    """Collects the messages of a topic and checks them in batches."""

    def __init__(self, robot: FieldRobot, output: str, sent: Sent) -> None:
        super().__init__()
        self.tally = Tally()
        self.latencies = Latencies()
        self.latest: tuple[float, float] = 0.0, 0.0
        """When the latest output came [s, monotonic], and its latency [s]."""
        self.last_base = 0
        self.last_model = 0
        """The model of the latest output that follows from one of them alone."""
        self._robot, self._output, self._sent = robot, output, sent
        self._delay = round(robot.delay * 1e9)

    def check(self, models: set[int], during: str) -> None:
        """Check what was collected, by the models that may be in use during something."""
        batch, arrivals = self.taken()
        if not batch:
            return
        tally = self.tally
        tally.received += len(batch)
        stamps, bases, values, deviations = decode(batch, covariance=True)
        known, instants, sent = self._sent.find((stamps + self._delay).tolist())
        self._note('strange', ~known, stamps, values, during)
        finite = np.isfinite(values).all(1) & np.isfinite(deviations).all(1)
        self._note('not_finite', ~finite, stamps, values, during)
        latency = (arrivals - sent)[known] * 1e-9
        if len(latency):
            self.latest = arrivals[-1] * 1e-9, float(latency[-1])
            self.latencies.add(latency)
        if not self._robot.description:
            self.last_base = BASES.index(bases[-1])
        stated = known & finite & (deviations > 0).any(1)
        if stated.any():
            which = np.array([BASES.index(base) for base in np.array(bases)[stated]]) if (
                not self._robot.description) else None
            self._judge(stamps[stated], instants[stated] - self._robot.delay, values[stated],
                        deviations[stated], which, models, during)

    def _judge(self, stamps: np.ndarray, t: np.ndarray, values: np.ndarray,
               deviations: np.ndarray, which: np.ndarray | None, models: set[int],
               during: str) -> None:
        sizes = {model: np.where(True if which is None else which == model,
                                 errors(self._robot, self._output, t, values, deviations, model),
                                 np.inf)
                 for model in sorted(models if which is None else set(which.tolist()))}
        # One latency for all, whichever model each of them follows from; the surest tell it.
        nearest = np.minimum.reduce(list(sizes.values()))
        latency = int((nearest.clip(0, FARTHEST)**2).sum(1).argmin())
        best = nearest[latency]
        follows = [model for model, size in sizes.items() if size[latency, -1] <= FARTHEST]
        if len(follows) == 1:
            self.last_model, = follows
        tally = self.tally
        tally.judged += len(best)
        tally.squares += float((best.clip(0, 1e3)**2).sum())
        tally.worst = max(tally.worst, float(best.max()))
        self._note('beyond', best > FARTHEST, stamps, values, during, best)

    def _note(self, what: str, bad: np.ndarray, stamps: np.ndarray, values: np.ndarray,
              during: str, sizes: np.ndarray | None = None) -> None:
        i = int(np.argmax(bad if sizes is None else sizes))
        by = '' if sizes is None else f' by {sizes[i]:.3g} deviations'
        self.tally.note(what, bad, f'{self._robot.name}/{self._output}: {int(bad.sum())} '
                        f'{what}{by} during {during}: stamp {stamps[i]}, '
                        f'{np.array2string(values[i], precision=4)}')

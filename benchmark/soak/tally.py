# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is common to all checks of outputs: collecting, decoding, counting, latencies."""
from collections.abc import Iterable
from dataclasses import dataclass, field
import time

import numpy as np

BINS = np.logspace(-5, 2, 1401)
"""Of latencies [s]."""

EXAMPLES = 8


@dataclass
class Tally:
    """What was found about the outputs of a topic."""

    received: int = 0
    not_finite: int = 0
    examples: list[str] = field(default_factory=list)    # the first things that were wrong

    def note(self, what: str, bad: np.ndarray, text: str) -> None:
        """Count those that are bad as an attribute; keep the text if there are few yet."""
        if bad.any():
            setattr(self, what, getattr(self, what) + int(bad.sum()))
            if len(self.examples) < EXAMPLES:
                self.examples.append(text)


class Latencies:
    """How late outputs came."""

    def __init__(self) -> None:
        self.counts = np.zeros(len(BINS) - 1, int)
        self.worst = 0.0

    def add(self, latencies: np.ndarray) -> None:
        """Count some [s]."""
        self.counts += np.histogram(latencies.clip(BINS[0], BINS[-1]), BINS)[0]
        self.worst = max(self.worst, float(latencies.max(initial=0.0)))

    @classmethod
    def of(cls, parts: Iterable['Latencies']) -> 'Latencies':
        """Return those of several topics together."""
        whole = cls()
        for part in parts:
            whole.counts = whole.counts + part.counts
            whole.worst = max(whole.worst, part.worst)
        return whole

    def quantile(self, share: float) -> float:
        """Return what this share of them does not exceed [s]; 0 if there are none."""
        total = np.cumsum(self.counts)
        return float(BINS[1:][np.searchsorted(total, share * total[-1])]) if total[-1] else 0.0


class Collector:
    """The messages of a topic that have arrived, and when."""

    def __init__(self) -> None:
        self._batch: list[bytes] = []
        self._arrivals: list[int] = []

    def take(self, data: bytes) -> None:
        """Collect a message."""
        self._arrivals.append(time.monotonic_ns())
        self._batch.append(data)

    def taken(self) -> tuple[list[bytes], np.ndarray]:
        """Return what was collected since the last time, and when it came [ns]."""
        batch, arrivals, self._batch, self._arrivals = self._batch, self._arrivals, [], []
        return batch, np.array(arrivals, dtype=np.int64)


def decode(batch: list[bytes], covariance: bool = False,
           ) -> tuple[np.ndarray, list[bytes], np.ndarray, np.ndarray]:
    """
    Return stamps [ns], frames, values and deviations, angular part first, of serialized messages.

    Of TwistStamped or AccelStamped, or of those with covariance; else there are no deviations.
    Serialized by the rules of CDR, version 1, with frames whose names are all of the same length.
    """
    length = int.from_bytes(batch[0][12:16], 'little')
    pad = -(12 + length) % 8
    fields = [('head', 'V4'), ('sec', '<i4'), ('nanosec', '<u4'), ('count', '<u4'),
              ('frame', f'S{length}'), ('pad', f'V{pad}'), ('values', '<f8', 6)]
    messages = np.frombuffer(b''.join(batch), np.dtype(
        [*fields, ('covariance', '<f8', (6, 6))] if covariance else fields))
    stamps = messages['sec'].astype(np.int64) * 1_000_000_000 + messages['nanosec']
    angular_first = [3, 4, 5, 0, 1, 2]
    deviations = np.sqrt(np.diagonal(messages['covariance'], axis1=1, axis2=2)[
        :, angular_first]) if covariance else np.empty((len(batch), 0))
    return (stamps, messages['frame'].tolist(), messages['values'][:, angular_first], deviations)

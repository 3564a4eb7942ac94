# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot of this benchmark: a Panda, and what its driver says of it."""
from collections.abc import Sequence
from importlib.metadata import distribution
from pathlib import Path
import struct

import numpy as np

JOINTS = [f'panda_joint{i}' for i in range(1, 8)]
BASE, TIP = 'panda_link0', 'panda_link8'
_FILES = distribution('example-robot-data')
URDF = next(Path(str(_FILES.locate_file(file))) for file in _FILES.files or ()
            if file.as_posix().endswith('/panda.urdf'))

PERIOD_NS = 1_000_000
_SAMPLES = 5000     # the motion repeats after this many
_JITTER_NS = 20_000
_stamp = struct.Struct('<iI').pack


class Driver:
    """
    A driver that reports positions and velocities at 1 kHz, as serialized messages.

    The joints swing with several frequencies. Positions are quantised by 1e-5 rad,
    velocities have noise of 1e-3 rad/s, stamps jitter by 20 us.
    """

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        t = np.arange(_SAMPLES)[:, None] * 2 * np.pi / _SAMPLES
        q: np.ndarray = np.zeros((_SAMPLES, len(JOINTS)))
        qd = np.zeros((_SAMPLES, len(JOINTS)))
        seconds = _SAMPLES * PERIOD_NS * 1e-9
        for harmonic in (1, 3, 7):
            phase = random.uniform(0, 2 * np.pi, len(JOINTS))
            q += 0.4 / harmonic * np.sin(harmonic * t + phase)
            qd += 0.4 * np.cos(harmonic * t + phase) * 2 * np.pi / seconds
        q[:, 3] -= 1.5
        q = np.round(q / 1e-5) * 1e-5
        qd += random.normal(0, 1e-3, qd.shape)
        self._bodies = [
            message_body(JOINTS, *sample) for sample in zip(q.tolist(), qd.tolist())]
        self._jitter = random.normal(0, _JITTER_NS, _SAMPLES).clip(
            -PERIOD_NS / 3, PERIOD_NS / 3).astype(int).tolist()
        self._count = 0

    def message(self, second: int = 1_700_000_000) -> bytes:
        """Return the next message."""
        i = self._count % _SAMPLES
        at = self._count * PERIOD_NS + self._jitter[i] + PERIOD_NS
        self._count += 1
        return (b'\0\1\0\0' + _stamp(second + at // 1_000_000_000, at % 1_000_000_000)
                + self._bodies[i])


def message_body(names: Sequence[str], position: Sequence[float],
                 velocity: Sequence[float]) -> bytes:
    """Return what follows the stamp: frame, names, positions, velocities, no efforts."""
    out = bytearray(8)      # room for the stamp, so that alignment is right

    def align(size: int) -> None:
        out.extend(bytes(-len(out) % size))

    for text in ('', *names):
        align(4)
        raw = text.encode() + b'\0'
        out.extend(struct.pack('<I', len(raw)) + raw)
        if not text:
            align(4)
            out.extend(struct.pack('<I', len(names)))
    for values in (position, velocity):
        align(4)
        out.extend(struct.pack('<I', len(values)))
        align(8)
        out.extend(struct.pack(f'<{len(values)}d', *values))
    out.extend(bytes(4))
    return bytes(out[8:])

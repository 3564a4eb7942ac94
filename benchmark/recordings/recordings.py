# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of a seven-joint arm in all formats, made as fast as possible."""
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
from pyarrow import csv, parquet
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

from screw_kinematics.screws.se3 import Array

JOINTS = tuple(f'panda_joint{i}' for i in range(1, 8))
FORMATS = ('mcap', 'mcap_zstd', 'sqlite3', 'ros1', 'csv', 'parquet')
RATE = 1000.0
START = 1_750_000_000_000_000_000
QUANTUM = 1e-6
_KIND = 'sensor_msgs/msg/JointState'


def motion(seed: int, count: int) -> tuple[Array, Array, Array]:
    """Return stamps [ns], and positions and velocities of slow sines, rounded as encoders do."""
    rng = np.random.default_rng(seed)
    stamps = START + seed * 3_600_000_000_000 + np.rint(np.arange(count) / RATE * 1e9).astype(int)
    t = np.arange(count) / RATE
    frequency, phase = rng.uniform(1.0, 4.0, 7), rng.uniform(0, 6, 7)
    q = 0.4 * np.sin(t[:, None] * frequency + phase) + [0, -0.7, 0, -2.2, 0, 1.6, 0.8]
    qd = 0.4 * frequency * np.cos(t[:, None] * frequency + phase)
    return stamps, np.rint(q / QUANTUM) * QUANTUM, qd


def write(folder: Path, seed: int, count: int, form: str) -> Path:
    """Write a recording; return its path."""
    stamps, q, qd = motion(seed, count)
    path = folder / f'recording_{seed:04d}'
    if form in ('csv', 'parquet'):
        columns = {'stamp_ns': stamps, **dict(zip(JOINTS, q.T)), **{
            f'{name}_velocity': column for name, column in zip(JOINTS, qd.T)}}
        table, path = pyarrow.table(columns), path.with_suffix(f'.{form}')
        csv.write_csv(table, path) if form == 'csv' else parquet.write_table(table, path)
        return path
    if form == 'ros1':
        store, path = get_typestore(Stores.ROS1_NOETIC), path.with_suffix('.bag')
        writer: Any = Ros1Writer(path)
    else:
        store = get_typestore(Stores.ROS2_JAZZY)
        storage = StoragePlugin.SQLITE3 if form == 'sqlite3' else StoragePlugin.MCAP
        writer = Writer(path, version=9, storage_plugin=storage)
        if form == 'mcap_zstd':
            writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection('/joint_states', _KIND, typestore=store)
        for stamp, data in zip(stamps.tolist(), _messages(store, form, stamps, q, qd)):
            writer.write(connection, stamp, data)
    return path


def _messages(store: Any, form: str, stamps: Array, q: Array, qd: Array) -> Iterator[bytes]:
    """Yield serialized joint states, all alike but for their stamps and numbers."""
    ros1 = form == 'ros1'
    head = store.types['std_msgs/msg/Header']
    time = store.types['builtin_interfaces/msg/Time'](sec=0x0BADCAFE, nanosec=0)
    sample = store.types[_KIND](
        head(**({'seq': 0} if ros1 else {}), stamp=time, frame_id=''), list(JOINTS),
        np.full(7, 1.25), np.full(7, 2.5), np.zeros(0))
    template = bytearray((store.serialize_ros1 if ros1 else store.serialize_cdr)(sample, _KIND))
    at = template.index(0x0BADCAFE.to_bytes(4, 'little'))
    at_q, at_qd = (template.index(np.full(7, x).tobytes()) for x in (1.25, 2.5))
    for stamp, positions, velocities in zip(stamps, q, qd):
        template[at:at + 8] = np.array(divmod(int(stamp), 10**9), '<u4').tobytes()
        template[at_q:at_q + 56] = positions.tobytes()
        template[at_qd:at_qd + 56] = velocities.tobytes()
        yield bytes(template)


def damage(path: Path) -> None:
    """Cut the file of a recording off in its middle."""
    file = next(f for f in path.iterdir() if f.suffix != '.yaml') if path.is_dir() else path
    file.write_bytes(file.read_bytes()[:file.stat().st_size // 2])

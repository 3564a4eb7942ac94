# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Shown motions as a file for the Rerun viewer."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .motion import ShownMotion
from .scene import QUANTITIES, round_scale, TRAIL_COLOUR, vectors
from ...errors import optional_module
from ...screws.rotations import quaternion_from_rotation


def write_rerun(path: Path, motions: Sequence[ShownMotion]) -> None:
    """Write links, tip, trail, arrows and time series of robots into a new .rrd file."""
    rr = optional_module('rerun', 'rerun', 'writing Rerun files', 'rerun-sdk')
    path.parent.mkdir(parents=True, exist_ok=True)
    with rr.RecordingStream('screw_kinematics') as stream:
        stream.save(path)
        stream.log('/', rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for motion in motions:
            _write(rr, stream, motion)


def _write(rr: Any, stream: Any, motion: ShownMotion) -> None:
    name, size = motion.name, motion.size
    scales = {key: round_scale(max(float(np.linalg.norm(vectors(s.twist, s.accel)[key]))
                                   for s in motion.snapshots), 0.4 * size)
              for key in QUANTITIES}
    trail = np.array([s.pose[:3, 3] for s in motion.snapshots])
    stream.log(f'{name}/trail', rr.LineStrips3D([trail], colors=[TRAIL_COLOUR]), static=True)
    for snapshot in motion.snapshots:
        stream.set_time('time', duration=snapshot.time)
        stream.log(f'{name}/links', rr.LineStrips3D(list(snapshot.skeleton),
                                                    radii=0.009 * size))
        tip = snapshot.pose[:3, 3]
        stream.log(f'{name}/tip', rr.Transform3D(
            translation=tip,
            quaternion=rr.Quaternion(xyzw=quaternion_from_rotation(snapshot.pose[:3, :3]))))
        for key, value in vectors(snapshot.twist, snapshot.accel).items():
            quantity = QUANTITIES[key]
            label = f'{quantity.label}, {scales[key]:g} m for 1 {quantity.unit}'
            stream.log(f'{name}/arrows/{key}', rr.Arrows3D(
                origins=[tip], vectors=[scales[key] * value], colors=[quantity.colour],
                radii=0.006 * size, labels=[label], show_labels=False))
            stream.log(f'series/{name}/{key}', rr.Scalars(value))

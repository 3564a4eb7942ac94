# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Smoothed motions of joints that came in different messages, at common instants."""
from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from .blocks import SmoothedBlock
from .interpolation import interpolate
from ..pipeline.joint_groups import JointGroup

_NODES = 4


class Joining:
    """
    Brings the groups of a robot's joints together.

    The instants are those of the group that comes least often; the others, being smooth,
    are interpolated. Robots whose joints come in one message pass unchanged.

    Parameters
    ----------
    n_joints : int
        Of the robot.
    lost : Counter
        Gets the samples that had no counterpart.

    """

    def __init__(self, n_joints: int, lost: Counter[str]) -> None:
        self._n_joints = n_joints
        self._lost = lost
        self._pending: dict[JointGroup, SmoothedBlock] = {}
        self._done = -(2**62)

    def add(self, group: JointGroup, block: SmoothedBlock,
            groups: Sequence[JointGroup]) -> Iterator[SmoothedBlock]:
        """
        Take a block of one group; yield blocks of all joints.

        Parameters
        ----------
        group : JointGroup
            Whose block it is.
        block : SmoothedBlock
            Follows the one before.
        groups : sequence of JointGroup
            The groups there are at present.

        """
        if group.complete:
            yield block
            return
        before = self._pending.get(group)
        self._pending[group] = block if before is None else _appended(before, block)
        for gone in self._pending.keys() - set(groups):
            del self._pending[gone]
        if sum(len(g.columns) for g in self._pending) == self._n_joints:
            yield from self._join()

    def _join(self) -> Iterator[SmoothedBlock]:
        limit = min(int(block.stamps[-1]) for block in self._pending.values())
        begin = max(self._done + 1, *(int(b.stamps[0]) for b in self._pending.values()))
        inside = {group: (block.stamps >= begin) & (block.stamps <= limit)
                  for group, block in self._pending.items()}
        clock = min(inside, key=lambda group: int(inside[group].sum()))
        chosen, at = self._pending[clock], inside[clock]
        instants = chosen.stamps[at]
        if not len(instants) or any(len(b.stamps) < _NODES for b in self._pending.values()):
            return
        orders = len(chosen.motion)
        motion = np.empty((orders, len(instants), self._n_joints))
        whole = np.ones(len(instants), dtype=bool)
        for group, block in self._pending.items():
            columns = list(group.columns)
            flat = np.moveaxis(block.motion, 0, 1).reshape(len(block.stamps), -1)
            between = interpolate(block.stamps, flat, instants)
            motion[:, :, columns] = np.moveaxis(
                between.reshape(len(instants), orders, len(columns)), 1, 0)
            # Nothing is known between two runs.
            last = np.clip(np.searchsorted(block.stamps, instants, side='right') + 1,
                           _NODES - 1, len(block.stamps) - 1)
            whole &= block.run[last] == block.run[last - _NODES + 1]
        self._lost['joints_too_far_apart_in_time'] += int((~whole).sum())
        if whole.any():
            yield SmoothedBlock(instants[whole], chosen.received[at][whole],
                                motion[:, whole], chosen.run[at][whole])
        self._done = limit
        for group, block in self._pending.items():
            keep = max(int(np.searchsorted(block.stamps, limit)) - _NODES, 0)
            self._pending[group] = SmoothedBlock(
                block.stamps[keep:], block.received[keep:], block.motion[:, keep:],
                block.run[keep:])


def _appended(before: SmoothedBlock, after: SmoothedBlock) -> SmoothedBlock:
    return SmoothedBlock(
        np.concatenate([before.stamps, after.stamps]),
        np.concatenate([before.received, after.received]),
        np.concatenate([before.motion, after.motion], axis=1),
        np.concatenate([before.run, after.run]))

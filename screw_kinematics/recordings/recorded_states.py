# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""States out of bags: what the node published, or the tool bag wrote, as histories."""
from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import reduce
from pathlib import Path
from struct import unpack_from

import numpy as np

from .history import History
from .recording import BROKEN, METADATA, read_metadata, Recording
from ..errors import ToolError, UnknownNameError
from ..messages.state_messages import read_states
from ..pipeline.outputs import KINDS, RECORDED
from ..screws.se3 import Array


def read_bag_histories(path: Path, quantities: Sequence[str]) -> list[History]:
    """Return the states in a bag, a history for each robot that has all of the quantities."""
    robots: dict[str, dict[str, list[bytes]]] = defaultdict(lambda: defaultdict(list))
    with Recording(path) as recording:
        for message in recording.messages({KINDS[output].type_name for output in RECORDED}):
            robot, _, output = message.topic.lstrip('/').rpartition('/')
            if output in RECORDED:
                robots[robot][output].append(message.data)
    if not robots:
        raise ToolError(f'{path}: no states of the node in it; allowed: a bag with its topics, '
                        'or one written by the tool bag')
    whole = {robot: outputs for robot, outputs in robots.items()
             if all(quantity in outputs for quantity in quantities)}
    if not whole:
        robot, outputs = next(iter(robots.items()))
        missing = next(quantity for quantity in quantities if quantity not in outputs)
        raise UnknownNameError(f'quantity of {robot} in {path}', missing, outputs)
    tips = _tip_frames(path)
    return [_history(robot, {q: outputs[q] for q in quantities}, tips.get(robot, 'tip'))
            for robot, outputs in whole.items()]


def _history(robot: str, messages: dict[str, list[bytes]], tip_frame: str) -> History:
    stamps, blocks = {}, {}
    for quantity, data in messages.items():
        at, block = read_states(KINDS[quantity].type_name, RECORDED[quantity], data)
        order = np.argsort(at, kind='stable')       # the clock may have been set back
        stamps[quantity], blocks[quantity] = at[order], block[order]
    common: Array = reduce(np.intersect1d, stamps.values())
    if not len(common):
        raise ToolError(f'{robot}: no instant has all of {", ".join(messages)}')
    rows = {quantity: block[np.searchsorted(stamps[quantity], common)]
            for quantity, block in blocks.items()}
    frame = _frame_id(next(iter(messages.values()))[0])
    return History.of_rows(robot, frame, tip_frame, common, rows)


def _frame_id(message: bytes) -> str:
    """Return the frame of a stamped message in plain little-endian CDR."""
    length, = unpack_from('<I', message, 12)
    return message[16:16 + length - 1].decode(errors='replace')


def _tip_frames(path: Path) -> dict[str, str]:
    """Return the tip frames that the tool bag wrote down, by robot."""
    ending = '.tip_frame'
    try:
        custom = read_metadata(path / METADATA)['custom_data']
        return {str(key).removesuffix(ending): str(value) for key, value in dict(custom).items()
                if str(key).endswith(ending)}
    except (OSError, *BROKEN):
        return {}

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the states of a recording go: a bag with the node's topics, tables, or a data set."""
from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
import sqlite3
from typing import Any, Protocol

import numpy as np

from .history import QUANTITIES
from .recording import full_name
from .states import RecordedRobot, StateBlock
from .storage import jazzy_types
from .tables import TableWriter
from ..errors import Reason, ToolError
from ..pipeline.compensation import WrenchWriter
from ..pipeline.group_motion import Motion
from ..pipeline.kinematics import State
from ..pipeline.moving_base import BaseMotion
from ..pipeline.message_writers import message_writer, MessageWriter
from ..pipeline.outputs import KINDS
from ..screws.rotations import quaternion_from_rotation
from ..screws.se3 import Array

_DAY = 86_400 * 10**9    # ns


class StateWriter(Protocol):
    """Takes the states of robots, one after another and block by block."""

    def write(self, robot: RecordedRobot, block: StateBlock) -> None:
        """Append states."""

    def close(self) -> None:
        """Write the rest."""


class BagWriter:
    """A bag of ROS 2, in mcap or sqlite3, with the messages the node would have published."""

    def __init__(self, path: Path, storage: str, namespace: str) -> None:
        self._types = jazzy_types('writing bags')
        from rosbags.rosbag2 import StoragePlugin, Writer
        self._writer = Writer(path, version=Writer.VERSION_LATEST,
                              storage_plugin=StoragePlugin[storage.upper()])
        self._path, self._namespace = path, namespace
        self._topics: dict[str, list[tuple[Any, MessageWriter | WrenchWriter]]] = {}
        with _told(path):
            self._writer.open()

    def write(self, robot: RecordedRobot, block: StateBlock) -> None:
        """Append states."""
        name = robot.settings.name
        if name not in self._topics:
            self._topics[name] = self._advertise(robot)
        motion, variances = (np.moveaxis(array, 1, 0).reshape(len(block.stamps), -1).tolist()
                             for array in (block.motion, block.variances))
        of_base = [None] * len(motion) if block.base_variances is None else [
            BaseMotion(stamp, (), row) for stamp, row in zip(
                block.stamps.tolist(), block.base_variances.tolist())]
        with _told(self._path):
            for stamp, received, values, moving, unsure, base in zip(
                    block.stamps.tolist(), block.received.tolist(), block.values.tolist(), motion,
                    variances, of_base):
                state = State(stamp, values, Motion(stamp, moving, unsure), robot.order, base)
                for connection, writer in self._topics[name]:
                    message = writer.encode(state)
                    if isinstance(message, Reason):
                        assert robot.sensor is not None
                        robot.sensor.left_out[message] += 1
                    else:
                        # Played back with the recording, states come when the samples come.
                        self._writer.write(connection, received, message)

    def close(self) -> None:
        """Write the rest."""
        with _told(self._path):
            self._writer.close()

    def _advertise(self, robot: RecordedRobot,
                   ) -> list[tuple[Any, MessageWriter | WrenchWriter]]:
        settings = robot.settings
        # The messages name the base only.
        topics = full_name(self._namespace, settings.topic).lstrip('/')
        self._writer.set_custom_data(
            f'{topics}.tip_frame', settings.frame_prefix + robot.model.tip_frame)
        return [(self._connection(f'{settings.topic}/{output}', KINDS[output].type_name),
                 WrenchWriter(robot.program.slices, settings, robot.sensor)
                 if output == 'compensated_wrench' and robot.sensor is not None else
                 message_writer(output, robot.program.slices, robot.model, settings,
                                world=robot.base.world if robot.base is not None else ''))
                for output in robot.outputs]

    def _connection(self, topic: str, type_name: str) -> Any:
        return self._writer.add_connection(
            full_name(self._namespace, topic), type_name, typestore=self._types)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Tell of a database that cannot be written by an error of the package."""
    try:
        yield
    except sqlite3.Error as error:
        raise ToolError(f'{path.name} cannot be written: {error}') from error


class TablesWriter:
    """A table for each robot, in the place that its name gives."""

    def __init__(self, place: Callable[[str], Path]) -> None:
        self._place = place
        self._tables: dict[Path, TableWriter] = {}

    def write(self, robot: RecordedRobot, block: StateBlock) -> None:
        """Append states."""
        self._append(self._place(robot.settings.name), robot, block.stamps,
                     _columns(robot, block))

    def close(self) -> None:
        """Write the rest."""
        for table in self._tables.values():
            table.close()

    def _append(self, file: Path, robot: RecordedRobot, stamps: Array, values: Sequence[Array],
                **more: str) -> None:
        if file not in self._tables:
            file.parent.mkdir(parents=True, exist_ok=True)
            self._tables[file] = _table(file, robot, **more)
        self._tables[file].write(stamps, values)


class DataSetWriter(TablesWriter):
    """Parts of a Parquet data set: ``robot=NAME/date=YYYY-MM-DD/RECORDING.parquet``."""

    def __init__(self, folder: Path, recording: str) -> None:
        super().__init__(lambda robot: folder / f'robot={robot.replace("/", "_")}')
        self._recording = recording

    def write(self, robot: RecordedRobot, block: StateBlock) -> None:
        """Append states."""
        values, days = _columns(robot, block), block.stamps // _DAY
        for day in np.unique(days).tolist():
            folder = self._place(robot.settings.name) / f'date={np.datetime64(day, "D")}'
            rows = days == day
            self._append(folder / f'{self._recording}.parquet', robot, block.stamps[rows],
                         [v[rows] for v in values], recording=self._recording)


def values_of(robot: RecordedRobot, block: StateBlock, output: str) -> Array:
    """Return the values of one output: (N, 6), or position and quaternion, (N, 7)."""
    values = block.values[:, robot.program.slices[KINDS[output].needs[0]]]
    if output != 'pose':
        return values
    rotations = values[:, 3:].reshape(-1, 3, 3)
    return np.concatenate([values[:, :3], quaternion_from_rotation(rotations)], axis=1)


def _table(file: Path, robot: RecordedRobot, **more: str) -> TableWriter:
    settings, model = robot.settings, robot.model
    return TableWriter(file, _quantities(robot), {
        'robot': settings.name,
        'base_frame': (settings.frame_prefix + model.base_frame if robot.base is None
                       else robot.base.world),
        'tip_frame': settings.frame_prefix + model.tip_frame, 'axes': settings.expressed_in,
        'reference_point': settings.reference_point, 'units': 'rad, m, s', **more})


def _columns(robot: RecordedRobot, block: StateBlock) -> list[Array]:
    return [values_of(robot, block, quantity) for quantity in _quantities(robot)]


def _quantities(robot: RecordedRobot) -> list[str]:
    """Return the outputs that a table has columns for; velocity is the twist again."""
    return [output for output in robot.outputs if output in QUANTITIES]

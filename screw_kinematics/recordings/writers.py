# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the states of recorded robots go: a bag with the node's topics, or tables."""
from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np

from .history import QUANTITIES
from .recorded_robots import full_name
from .robot_states import RobotStates, StateBlock
from .tables import ENDINGS, TableWriter
from ..errors import MissingExtraError, ToolError
from ..pipeline.outputs import Frames, KINDS, make_send
from ..screws.rotations import quaternion_from_rotation
from ..screws.se3 import Array


class StateWriter(Protocol):
    """Takes the states of several robots, block by block."""

    def __enter__(self) -> StateWriter:
        """Open the output."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        """Close it, also after an error."""

    def write(self, robot: RobotStates, block: StateBlock) -> None:
        """Append states."""


def make_writer(path: Path, robots: Sequence[RobotStates], storage: str,
                namespace: str) -> StateWriter:
    """
    Return the writer for a path: a table if it ends in .csv or .parquet, else a bag.

    Raises
    ------
    ToolError
        There is something at the path already.

    """
    if path.suffix in ENDINGS:
        return _Tables(path, robots)
    if path.exists():
        raise ToolError(f'{path} exists already; choose another output')
    return _Bag(path, robots, storage, namespace)


class _Bag:
    """A bag of ROS 2 with the messages the node would have published."""

    def __init__(self, path: Path, robots: Sequence[RobotStates], storage: str,
                 namespace: str) -> None:
        try:
            from rosbags.rosbag2 import StoragePlugin, Writer
            from rosbags.typesys import get_typestore, Stores
        except ImportError:
            raise MissingExtraError('rosbags', 'bag', 'writing bags') from None
        self._writer = Writer(path, version=Writer.VERSION_LATEST,
                              storage_plugin=StoragePlugin[storage.upper()])
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._robots = robots
        self._namespace = namespace
        self._sends: dict[str, list[Any]] = {}
        self._received = 0

    def __enter__(self) -> _Bag:
        self._writer.open()
        for robot in self._robots:
            settings, model = robot.settings, robot.model
            base = settings.frame_prefix + model.base_frame
            tip = settings.frame_prefix + model.tip_frame
            frames = Frames(base, tip, tip if settings.expressed_in == 'tip' else base)
            self._sends[settings.name] = [
                make_send(output, self._publisher(robot, output), robot.program.slices, frames,
                          lambda derivative: ()) for output in robot.outputs]
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        # Closed whole after errors too: what was computed until then stays readable.
        self._writer.close()

    def write(self, robot: RobotStates, block: StateBlock) -> None:
        """Append states."""
        sends = self._sends[robot.settings.name]
        for stamp, self._received, values in zip(
                block.stamps.tolist(), block.received.tolist(), block.values.tolist()):
            for send in sends:
                send(stamp, values)

    def _publisher(self, robot: RobotStates, output: str) -> Any:
        connection = self._writer.add_connection(
            full_name(self._namespace, f'{robot.settings.name}/{output}'), KINDS[output].type_name,
            typestore=self._types)
        write = self._writer.write

        def publish(data: bytes) -> None:
            # Played back together with the recording, states come when the samples come.
            write(connection, self._received, data)
        return publish


class _Tables:
    """A table for each robot."""

    def __init__(self, path: Path, robots: Sequence[RobotStates]) -> None:
        self._stack = ExitStack()
        self._writers: dict[str, TableWriter] = {}
        for robot in robots:
            name = robot.settings.name
            file = path if len(robots) == 1 else path.with_stem(f'{path.stem}_{name}')
            self._writers[name] = TableWriter(file, _columns(robot), {
                'robot': name, 'base_frame': robot.model.base_frame,
                'tip_frame': robot.model.tip_frame, 'axes': robot.settings.expressed_in,
                'reference_point': robot.settings.reference_point})

    def __enter__(self) -> _Tables:
        for writer in self._writers.values():
            self._stack.enter_context(writer)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        self._stack.close()

    def write(self, robot: RobotStates, block: StateBlock) -> None:
        """Append states."""
        self._writers[robot.settings.name].write(
            block.stamps, [values_of(robot, block, quantity) for quantity in _columns(robot)])


def values_of(robot: RobotStates, block: StateBlock, output: str) -> Array:
    """Return the values of one output: (N, 6), or position and quaternion, (N, 7)."""
    values = block.values[:, robot.program.slices[KINDS[output].needs[0]]]
    if output != 'pose':
        return values
    quaternions = quaternion_from_rotation(values[:, 3:].reshape(-1, 3, 3))
    return np.concatenate([values[:, :3], quaternions], axis=1)


def _columns(robot: RobotStates) -> list[str]:
    """Return the outputs that a table has columns for; velocity is the twist again."""
    return [output for output in robot.outputs if output in QUANTITIES]

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages out of the bags of ROS 1, in the encoding of ROS 2."""
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .storage import CDR, Connection, jazzy_types, Message


class Ros1Bag:
    """A bag of ROS 1, opened."""

    def __init__(self, path: Path) -> None:
        self._types = jazzy_types('reading bags of ROS 1')     # which drop the seq of headers
        from rosbags.rosbag1 import Reader
        self.path = path
        self.damage: list[str] = []
        self.connections: list[Connection] = []
        self.start = 0
        self._reader: Any = None
        try:
            reader = Reader(path)
            reader.open()
            self.connections = [Connection(c.topic, c.msgtype, CDR, c.msgcount)
                                for c in reader.connections]
            self.start = reader.start_time if reader.message_count else 0
            self._reader = reader
        except Exception as error:      # a broken file raises whatever its bytes lead to
            self.damage.append(f'{path}: {_first_line(error)} (rosbag reindex may mend it)')

    def close(self) -> None:
        """Let go of the file."""
        if self._reader is not None:
            self._reader.close()

    def messages(self, kinds: set[str], topics: set[str] | None) -> Iterator[Message]:
        """Yield messages of some types, and topics unless None, in order of reception."""
        if self._reader is None:
            return
        wanted = [c for c in self._reader.connections
                  if c.msgtype in kinds and (topics is None or c.topic in topics)]
        if not wanted:
            return
        last = 0
        try:
            for connection, last, data in self._reader.messages(wanted):
                yield Message(connection.topic, connection.msgtype, last,
                              bytes(self._types.ros1_to_cdr(data, connection.msgtype)))
        except Exception as error:      # as above
            self.damage.append(f'{self.path}: unreadable from {last} ns on: {_first_line(error)}')


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]

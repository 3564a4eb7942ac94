# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading recorded bags, intact or damaged, one message at a time."""
from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from .salvage import salvage
from ..errors import MissingExtraError, ToolError

STORAGES = ('.mcap', '.db3')
# What the readers raise on broken files, besides errors of their own: a cut-off record may
# fail as an index, a length, a text or a database error, depending on where the cut is.
_BROKEN = (OSError, ValueError, LookupError, TypeError, ArithmeticError, RuntimeError,
           AttributeError, AssertionError, EOFError)


class Message(NamedTuple):
    """A recorded message: where, what, when it was received [ns], and its CDR bytes."""

    topic: str
    kind: str
    received: int
    data: bytes


class Recording:
    """
    A bag of ROS 2: a directory, or one of its storage files.

    Parameters
    ----------
    path : path
        Directory with ``metadata.yaml``, or a file ending in .mcap or .db3.

    Attributes
    ----------
    damage : list of str
        What was found broken so far; messages that could be saved were delivered.
    topics : dict of str to str
        Message types by topic; empty if the bag's index is lost.

    Raises
    ------
    ToolError
        There is no bag at the path.
    MissingExtraError
        rosbags is not installed.

    """

    def __init__(self, path: Path) -> None:
        try:
            import rosbags.rosbag2 as rosbag2
        except ImportError:
            raise MissingExtraError('rosbags', 'bag', 'reading bags') from None
        self.path = path
        self.damage: list[str] = []
        self.topics: dict[str, str] = {}
        self.message_count = 0
        self._files = _storage_files(path)
        self._reader: Any = None
        self._errors = (*_BROKEN, rosbag2.ReaderError, _sqlite_error())
        try:
            reader = rosbag2.Reader(path if path.is_file() or _has_metadata(path)
                                    else self._files[0])
            reader.open()
        except self._errors as error:
            self.damage.append(f'{path}: {_first_line(error)}')
            return
        if path.is_dir() and not _has_metadata(path):
            # The recorder was killed before it wrote the metadata; the data may be whole.
            self.damage.append(f'{path}: metadata.yaml is missing')
            reader.close()
            return
        self._reader = reader
        self.topics = {c.topic: c.msgtype for c in reader.connections}
        self.message_count = reader.message_count

    def messages(self, kinds: set[str]) -> Iterator[Message]:
        """
        Yield the messages of some types, in order of reception.

        What comes after damage is read in the order of the file, and what it left out is
        told in ``damage``.

        Parameters
        ----------
        kinds : set of str
            Message types, as 'sensor_msgs/msg/JointState'.

        """
        delivered: Counter[str] = Counter()
        if self._reader is not None:
            try:
                wanted = [c for c in self._reader.connections if c.msgtype in kinds]
                for connection, received, data in (
                        self._reader.messages(wanted) if wanted else ()):
                    delivered[connection.topic] += 1
                    yield Message(connection.topic, connection.msgtype, received, data)
                lost = sum(c.msgcount for c in wanted) - sum(delivered.values())
                if lost > 0:
                    self.damage.append(f'{self.path}: {lost} messages are unreadable')
                return
            except self._errors as error:
                self.damage.append(f'{self.path}: {_first_line(error)}')
            finally:
                self._reader.close()
        for file in self._files:
            for message in salvage(file, self.damage):
                if message[1] in kinds:
                    delivered[message[0]] -= 1
                    if delivered[message[0]] < 0:    # not yielded before the damage
                        yield Message(*message)


def _storage_files(path: Path) -> list[Path]:
    if path.is_file() and path.suffix in STORAGES:
        return [path]
    files = sorted(file for ending in STORAGES for file in path.glob(f'*{ending}'))
    compressed = path.is_dir() and any(path.glob('*.zstd'))
    if not files and not compressed:
        raise ToolError(f'{path}: no bag there; allowed: a directory with files ending in '
                        f'{" or ".join(STORAGES)}, or one such file')
    return files


def _has_metadata(path: Path) -> bool:
    return (path / 'metadata.yaml').is_file()


def _sqlite_error() -> type[Exception]:
    """Return the error class of the SQLite binding that rosbags reads with."""
    try:
        import apsw
        return apsw.Error    # type: ignore[no-any-return]
    except ImportError:
        import sqlite3
        return sqlite3.Error


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]

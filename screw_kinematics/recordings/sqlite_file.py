# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages out of the SQLite files of rosbag2, whole or broken, without a trace left in them."""
from __future__ import annotations

from collections.abc import Iterator
from functools import partial
import os
from pathlib import Path
import shutil
import sqlite3
from tempfile import TemporaryDirectory

from .storage import Connection, Message, ros2_name, unpacked

_JOURNALS = ('-wal', '-journal')
_STRIDES = 40
_LARGEST = 1 << 40      # size that a header is believed [bytes]
_ERRORS = (sqlite3.Error, UnicodeDecodeError)      # whose texts hold bytes of broken files


class SqliteFile:
    """
    A database of messages, opened.

    Where a recorder that was killed left a journal beside the file, both are copied to a
    temporary folder and put together there: SQLite would write into the recording.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damage: list[str] = []
        self.connections: list[Connection] = []
        self.start = 0
        self._topics: dict[int, tuple[str, str]] = {}
        self._copy: TemporaryDirectory[str] | None = None
        self._database = self._open()
        try:
            for number, topic, kind, encoding in self._database.execute(
                    'SELECT id, name, type, serialization_format FROM topics '
                    f'WHERE {_are("integer", "id")} '
                    f'AND {_are("text", "name", "type", "serialization_format")}'):
                self._topics[number] = topic, ros2_name(kind)
                self.connections.append(Connection(topic, ros2_name(kind), encoding, None))
            first = self._database.execute(
                f'SELECT timestamp FROM messages WHERE {_are("integer", "timestamp")} '
                'ORDER BY id LIMIT 1').fetchone()
            self.start = first[0] if first else 0
        except _ERRORS as error:
            self.damage.append(f'{path}: {error}')

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()
        if self._copy is not None:
            self._copy.cleanup()

    def messages(self, kinds: set[str], topics: set[str] | None) -> Iterator[Message]:
        """Yield messages of some types, and topics unless None, in order of reception."""
        wanted = [number for number, (topic, kind) in self._topics.items()
                  if kind in kinds and (topics is None or topic in topics)]
        among = (f'topic_id IN ({", ".join(map(str, wanted))}) '
                 f'AND {_are("integer", "timestamp")} AND {_are("blob", "data")}')
        last = -2**63
        try:
            for number, received, data in self._database.execute(
                    f'SELECT topic_id, timestamp, data FROM messages WHERE {among} '
                    'ORDER BY timestamp, id'):
                yield from self._message(number, received, data)
                last = received
        except _ERRORS as error:
            self.damage.append(f'{self.path}: {error}, from {last} ns on' if last > 0
                               else f'{self.path}: {error}')
            yield from self._beyond(among, last)

    def _beyond(self, among: str, last: int) -> Iterator[Message]:
        """Yield what is later than an instant, in the order of the rows, beyond broken pages."""
        row, stride = -1, 1
        for _ in range(_STRIDES):
            try:
                for row, number, received, data in self._database.execute(
                        f'SELECT id, topic_id, timestamp, data FROM messages WHERE id > {row} '
                        f'AND timestamp > {last} AND +{among} ORDER BY id'):
                    yield from self._message(number, received, data)
                    stride = 1
                return
            except _ERRORS:
                row += stride
                stride *= 2

    def _message(self, number: int, received: int, data: bytes) -> Iterator[Message]:
        return unpacked(Message(*self._topics[number], received, data), self.path, self.damage)

    def _open(self) -> sqlite3.Connection:
        file, mode = self.path, 'immutable=1'
        journals = [self.path.with_name(self.path.name + ending) for ending in _JOURNALS]
        whole, there = _size_in_header(file), file.stat().st_size
        if there < whole or any(
                journal.exists() and journal.stat().st_size for journal in journals):
            self._copy = TemporaryDirectory(prefix='screw_kinematics_')
            for part in (self.path, *journals):
                if part.exists():
                    shutil.copy(part, self._copy.name)
            file, mode = Path(self._copy.name, self.path.name), 'mode=rw'
        if there < whole:
            self.damage.append(f'{self.path}: cut off at byte {there} of {whole}')
            os.truncate(file, whole)    # SQLite reads nothing of a file that is too short
        name = str(file.absolute()).replace('%', '%25').replace('?', '%3f').replace('#', '%23')
        database = sqlite3.connect(f'file:{name}?{mode}', uri=True)
        database.text_factory = partial(str, encoding='utf-8', errors='replace')
        return database


def _size_in_header(path: Path) -> int:
    """Return how large a database says that it is [bytes]; 0 where it does not say."""
    with path.open('rb') as file:
        header = file.read(100)
    page, pages = (int.from_bytes(header[i:j], 'big') for i, j in ((16, 18), (28, 32)))
    # 1 stands for 65536; the count is valid as of the last change that wrote it.
    size = (65536 if page == 1 else page) * pages if header[24:28] == header[92:96] else 0
    return size if size <= _LARGEST else 0


def _are(kind: str, *columns: str) -> str:
    """Return the condition that columns hold values of a type, which SQLite does not ensure."""
    return ' AND '.join(f"typeof({column}) = '{kind}'" for column in columns)

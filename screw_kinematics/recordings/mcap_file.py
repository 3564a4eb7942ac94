# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Messages out of MCAP files, whole or broken.

The records are walked from the first byte on, so that nothing hangs on the index at the end,
which a recorder that was killed never wrote. Where a record is broken, reading goes on at the
next chunk that the index knows of; of a chunk that is cut off, all that stands before the cut
is read. Format: https://mcap.dev/spec
"""
from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
import mmap
from pathlib import Path
from struct import error as TooShort, Struct
from typing import Any, NamedTuple
from zlib import crc32

from .storage import Connection, Message, ros2_name, unpacked, zstd
from ..errors import MissingExtraError, optional_module

MAGIC = b'\x89MCAP0\r\n'
LARGEST_CHUNK = 1 << 30
"""No chunk is unpacked beyond this [bytes]."""

_FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 2, 3, 4, 5, 6
_CHUNK_INDEX, _STATISTICS, _DATA_END = 8, 11, 15
_LOOSE = 1 << 22         # bytes of messages outside chunks that are ordered together
_NO_TIME = 1 << 63       # log times beyond are not times

_record = Struct('<BQ').unpack_from
_u16 = Struct('<H').unpack_from
_u32 = Struct('<I').unpack_from
_u64 = Struct('<Q').unpack_from
_message = Struct('<HIQ').unpack_from
_chunk = Struct('<QQQI').unpack_from


class Section(NamedTuple):
    """A part of the file that holds messages: a chunk, or some messages outside chunks."""

    start: int
    begin: int
    end: int
    is_chunk: bool
    cut: bool


class Channel(NamedTuple):
    """A channel: its topic, the type of its messages, and how they are encoded."""

    topic: str
    kind: str
    encoding: str


class McapFile:
    """An MCAP file, opened."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damage: list[str] = []
        self._schemas: dict[int, str] = {0: ''}
        self._channels: dict[int, Channel] = {}
        self._counts: dict[int, int] = {}
        self._sections: list[Section] = []
        self._indexed: list[int] = []
        with path.open('rb') as file:
            # An empty file cannot be mapped.
            self._data: Any = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if (
                path.stat().st_size) else b''
        if self._data[:8] != MAGIC:
            self._broken('it does not begin as an MCAP file, at byte 0')
            self.connections, self.start = [], 0
            return
        self._read_index()
        listed = bool(self._channels)
        self._walk()
        if not listed:
            for section in self._sections:      # for the channels in chunks
                self._read(section, {}, [])
        self.connections = [
            Connection(channel.topic, channel.kind, channel.encoding,
                       self._counts.get(number, 0) if self._counts else None)
            for number, channel in self._channels.items()]
        self.start = min((section.start for section in self._sections), default=0)

    def close(self) -> None:
        """Let go of the file."""
        if self._data:
            self._data.close()

    def messages(self, kinds: set[str], topics: set[str] | None) -> Iterator[Message]:
        """Yield messages of some types, and topics unless None, in order of reception."""
        wanted = {number: channel for number, channel in self._channels.items()
                  if channel.kind in kinds and (topics is None or channel.topic in topics)}
        waiting: list[Message] = []
        for section in sorted(self._sections, key=lambda section: section.start):
            ready = bisect_right(waiting, section.start, key=_received)
            yield from waiting[:ready]
            # Those of one time stay in the order in which they stand in the file.
            waiting = waiting[ready:] + self._read(section, wanted, self.damage)
            waiting.sort(key=_received)
            self._release()
        yield from waiting

    def _release(self) -> None:
        """Let go of the pages that were read: memory stays small however long the file is."""
        if hasattr(self._data, 'madvise'):
            self._data.madvise(mmap.MADV_DONTNEED)

    def _broken(self, what: str) -> None:
        self.damage.append(f'{self.path}: {what}')

    def _read_index(self) -> None:
        """Learn from the end of the file, if it is there: channels, counts, where chunks are."""
        end = len(self._data) - 8 - 29
        if end < 8 or self._data[-8:] != MAGIC or _record(self._data, end) != (_FOOTER, 20):
            return
        at, = _u64(self._data, end + 9)
        if not 8 <= at < end:
            return
        try:
            while at < end:
                opcode, length = _record(self._data, at)
                at, body = at + 9 + length, at + 9
                if opcode == _CHUNK_INDEX:
                    self._indexed.append(_u64(self._data, body + 16)[0])
                elif opcode == _STATISTICS:
                    self._read_counts(body)
                else:
                    self._learn(self._data, opcode, body)
        except (TooShort, UnicodeDecodeError):
            self._broken(f'its index is unreadable at byte {at}')
        self._indexed.sort()

    def _read_counts(self, at: int) -> None:
        size, = _u32(self._data, at + 42)
        for entry in range(at + 46, at + 46 + size, 10):
            self._counts[_u16(self._data, entry)[0]] = _u64(self._data, entry + 2)[0]

    def _walk(self) -> None:
        """Find the parts that hold messages, from the first record to the end of the data."""
        data, size, at = self._data, len(self._data), 8
        while at < size:
            opcode, length = _record(data, at) if size - at >= 9 else (0, 0)
            body, end = at + 9, at + 9 + length
            if opcode == _DATA_END and end <= size:
                if data[-8:] != MAGIC:
                    self._broken(f'cut off at byte {size}, behind its last message')
                return
            try:
                if not opcode or end > size and opcode != _CHUNK:
                    raise TooShort
                self._enter(opcode, body, min(end, size), end > size)
                if end > size:
                    raise TooShort
                at = end
            except (TooShort, UnicodeDecodeError):
                after = next((chunk for chunk in self._indexed if chunk > at), size)
                self._broken(f'cut off at byte {size}' if after == size and (
                    opcode or size - at < 9)
                             else f'unreadable from byte {at} to {after}')
                at = after
        if not self.damage:
            self._broken(f'the recording was not closed; it ends at byte {size}')

    def _enter(self, opcode: int, body: int, end: int, cut: bool) -> None:
        """Take in a record: where messages are, or what they are."""
        last = self._sections[-1] if self._sections else Section(0, 0, 0, True, False)
        if opcode == _CHUNK:
            self._sections.append(
                Section(_time(self._data, body, last.start), body, end, True, cut))
        elif opcode == _MESSAGE:
            time = _time(self._data, body + 6, last.start)
            if not last.is_chunk and last.end == body - 9 and end - last.begin < _LOOSE:
                self._sections[-1] = last._replace(start=min(last.start, time), end=end)
            else:
                self._sections.append(Section(time, body - 9, end, False, False))
                self._release()
        else:
            self._learn(self._data, opcode, body)

    def _learn(self, data: Any, opcode: int, at: int) -> None:
        """Take in a record if it is a schema or a channel."""
        if opcode == _SCHEMA:
            self._schemas[_u16(data, at)[0]] = ros2_name(_text(data, at + 2)[0])
        elif opcode == _CHANNEL:
            number, schema = _u16(data, at)[0], _u16(data, at + 2)[0]
            topic, at_encoding = _text(data, at + 4)
            self._channels[number] = Channel(
                topic, self._schemas.get(schema, ''), _text(data, at_encoding)[0])

    def _read(self, section: Section, wanted: dict[int, Channel], damage: list[str],
              ) -> list[Message]:
        """Return the wanted messages of a section, as far as it can be read."""
        found: list[Message] = []
        time = section.start
        try:
            data, at, end = self._data, section.begin, section.end
            if section.is_chunk:
                data = self._unpack(section)
                at, end = 0, len(data)
            while at < end:
                opcode, length = _record(data, at)
                body, at = at + 9, at + 9 + length
                if at > end or not opcode:
                    raise TooShort('a record reaches beyond its end')
                if opcode == _MESSAGE:
                    number, _, log_time = _message(data, body)
                    if number in wanted:
                        # A clock that ran below zero is no time: that of the message before.
                        time = log_time if log_time < _NO_TIME else time
                        found += unpacked(Message(
                            wanted[number].topic, wanted[number].kind, time,
                            data[body + 22:at]), self.path, damage)
                else:
                    self._learn(data, opcode, body)
        except MissingExtraError:
            raise
        except Exception as error:      # the decompressors have errors of their own
            if not section.cut:         # which was told
                damage.append(f'{self.path}: chunk at byte {section.begin - 9} is unreadable: '
                              f'{str(error) or type(error).__name__}')
        return found

    def _unpack(self, section: Section) -> bytes:
        """Return the records of a chunk; of one that is cut off, those before the cut."""
        _, _, size, checksum = _chunk(self._data, section.begin)
        if size > LARGEST_CHUNK:
            raise ValueError(f'it is said to hold {size} bytes, more than {LARGEST_CHUNK}')
        compression, at = _text(self._data, section.begin + 28)
        packed = self._data[at + 8:section.end]
        records = unpack(packed, compression, size)
        if checksum and not section.cut and crc32(records) != checksum:
            raise ValueError('its checksum is wrong')
        return records


def unpack(packed: bytes, compression: str, size: int) -> bytes:
    """Return the records of a chunk as far as they are there."""
    if compression == 'zstd':
        return bytes(zstd().ZstdDecompressor().decompress(packed, size))
    if compression == 'lz4':
        lz4 = optional_module('lz4.frame', 'bag', 'reading chunks compressed by lz4')
        return bytes(lz4.LZ4FrameDecompressor().decompress(packed, size))
    if compression:
        raise ValueError(f'compressed by {compression!r}; allowed: zstd, lz4 or nothing')
    return packed[:size]


def _received(message: Message) -> int:
    return message.received


def _time(data: Any, at: int, instead: int) -> int:
    """Return a time of reception; another one where the clock ran below zero."""
    time: int = _u64(data, at)[0]
    return time if time < _NO_TIME else instead


def _text(data: Any, at: int) -> tuple[str, int]:
    """Return a string and where it ends."""
    length, = _u32(data, at)
    end = at + 4 + length
    if end > len(data):
        raise TooShort('a text reaches beyond the end')
    return str(data[at + 4:end], 'utf-8'), end

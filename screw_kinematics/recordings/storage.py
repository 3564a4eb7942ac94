# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the files of a bag have in common, whatever their format."""
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, IO, NamedTuple, Protocol

from ..errors import optional_module

CDR = 'cdr'
ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'


class Message(NamedTuple):
    """A recorded message: where, what, when it was received [ns], and its CDR bytes."""

    topic: str
    kind: str
    received: int
    data: bytes


class Connection(NamedTuple):
    """A topic in a file: its message type, their encoding, and how many are promised, if known."""

    topic: str
    kind: str
    encoding: str
    promised: int | None


class StorageFile(Protocol):
    """One file of a bag."""

    connections: list[Connection]    # a topic may have several types
    start: int                       # when its first message was received [ns]
    damage: list[str]                # found so far, each with the file and the byte or the message

    def messages(self, kinds: set[str], topics: set[str] | None) -> Iterator[Message]:
        """Yield messages of some types, and topics unless None, in order of reception."""

    def close(self) -> None:
        """Let go of the file."""


def zstd() -> Any:
    """Return Python's module for Zstandard."""
    try:
        from compression import zstd    # from Python 3.14 on
    except ImportError:
        return optional_module('backports.zstd', 'bag', 'reading compressed recordings',
                               'backports.zstd')
    return zstd


def jazzy_types(what: str) -> Any:
    """Return rosbags' types of the messages of ROS 2 Jazzy, which something needs."""
    typesys = optional_module('rosbags.typesys', 'bag', what)
    return typesys.get_typestore(typesys.Stores.ROS2_JAZZY)


def unpacked(message: Message, path: Path, damage: list[str]) -> Iterator[Message]:
    """Yield a message that may be compressed by itself; it is damage if that cannot be undone."""
    if message.data[:4] != ZSTD_MAGIC:      # one in CDR begins with a zero
        yield message
        return
    try:
        yield message._replace(data=bytes(zstd().decompress(message.data)))
    except zstd().ZstdError:
        damage.append(f'{path}: a message on {message.topic} cannot be unpacked')


def unpack_file(source: IO[bytes], target: IO[bytes]) -> None:
    """Unpack a file compressed by Zstandard; raise EOFError behind what is there of it."""
    decompressor = zstd().ZstdDecompressor()
    while packed := source.read(1 << 18):
        while packed:
            if decompressor.eof:        # several frames may follow each other
                decompressor = zstd().ZstdDecompressor()
            target.write(decompressor.decompress(packed))
            packed = decompressor.unused_data
    if not decompressor.eof:
        raise EOFError('it ends before its data do')


def ros2_name(kind: str) -> str:
    """
    Return the ROS 2 name of a message type.

    Examples
    --------
    >>> ros2_name('sensor_msgs/JointState')
    'sensor_msgs/msg/JointState'

    """
    return kind if kind.count('/') != 1 else kind.replace('/', '/msg/')


def is_compressed(path: Path) -> bool:
    """Return whether a file as a whole is compressed by Zstandard."""
    with path.open('rb') as file:
        return file.read(4) == ZSTD_MAGIC

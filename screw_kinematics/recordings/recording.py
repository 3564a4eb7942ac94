# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recorded bags, of ROS 2 and ROS 1, intact or damaged, one message at a time."""
from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
import re
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from .mcap_file import McapFile
from .ros1_bag import Ros1Bag
from .sqlite_file import SqliteFile
from .storage import CDR, Connection, is_compressed, Message, StorageFile, unpack_file, zstd
from ..errors import MalformedMessageError, ToolError
from ..messages.joint_state import JointSample, JointStateDecoder

JOINT_STATE = 'sensor_msgs/msg/JointState'
STRING = 'std_msgs/msg/String'
METADATA = 'metadata.yaml'

FORMATS: dict[str, Callable[[Path], StorageFile]] = {
    '.mcap': McapFile, '.db3': SqliteFile, '.bag': Ros1Bag}

Sample = tuple[str, int, JointSample | MalformedMessageError]
"""Topic, time of reception [ns], and what was read."""


class Recording:
    """
    A bag: a directory, with ``metadata.yaml`` or without, or a file ending in .mcap, .db3, .bag.

    Files may be compressed as a whole (.zstd). What is broken is told by ``damage``; messages
    that could be saved are delivered.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._damage: list[str] = []
        self._unpacked: TemporaryDirectory[str] | None = None
        files, promised = self._find_files()
        self._files = [self._open(file) for file in files]
        if all(file.start for file in self._files):
            self._files.sort(key=lambda file: file.start)
        counts: dict[tuple[str, str, str], int | None] = {}
        for c in [c for file in self._files for c in file.connections]:
            key, before = c[:3], counts.get(c[:3], 0)
            counts[key] = None if c.promised is None or before is None else (
                before + c.promised)
        self.connections = [
            Connection(*key, promised.get(key[:2]) if count is None else count)
            for key, count in counts.items()]

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, *_: object) -> None:
        for file in self._files:
            file.close()
        if self._unpacked is not None:
            self._unpacked.cleanup()

    @property
    def damage(self) -> list[str]:
        """Return what was found broken so far, each a sentence that names the file."""
        found = [*self._damage, *(line for file in self._files for line in file.damage)]
        return list(dict.fromkeys(found))

    @property
    def joint_state_count(self) -> int:
        """How many joint states are promised; 0 if that is not known."""
        return sum(c.promised or 0 for c in self.connections if c.kind == JOINT_STATE)

    def messages(self, kinds: set[str], topics: set[str] | None = None) -> Iterator[Message]:
        """Yield the messages of some types, of all topics or some, in order of reception."""
        delivered: Counter[tuple[str, str]] = Counter()
        for file in self._files:
            for message in file.messages(kinds, topics):
                delivered[message[:2]] += 1
                yield message
        for c in self.connections:
            lost = (c.promised or 0) - delivered[c.topic, c.kind]
            if c.kind in kinds and (topics is None or c.topic in topics) and lost > 0:
                self._damage.append(f'{self.path}: {lost} of {c.promised} messages on {c.topic} '
                                    'are not there')

    def samples(self, topics: set[str]) -> Iterator[Sample]:
        """Yield the joint states on some topics, in order of reception."""
        decode = JointStateDecoder().decode
        for topic, _, received, data in self.messages({JOINT_STATE}, topics):
            try:
                yield topic, received, decode(data)
            except MalformedMessageError as error:
                yield topic, received, error

    def require_joint_states(self, topics: set[str]) -> None:
        """
        Raise ToolError if one of the topics has no joint states that can be read.

        Where a file is so damaged that nothing is known of its topics, none is missed.
        """
        there = {c.topic: c.encoding for c in self.connections if c.kind == JOINT_STATE}
        for topic in sorted(topics):
            encoding = there.get(topic)
            if encoding == CDR or not self.connections and self.damage:
                continue
            foreign = sorted({c.encoding for c in self.connections} - {CDR}
                             if encoding is None else {encoding})
            if foreign and not (encoding is None and there):
                raise ToolError(
                    f'{self.path}: its messages are encoded as {", ".join(foreign)}, not in the '
                    'CDR of ROS 2; convert the file (mcap convert, rosbags-convert), or write its '
                    'joint states to a table, .csv or .parquet')
            raise ToolError(f'{self.path}: no joint states on {topic}; topics of that type: '
                            f'{", ".join(sorted(there)) or "none"}')

    def _find_files(self) -> tuple[list[Path], dict[tuple[str, str], int]]:
        """Return the storage files, and the counts by topic and type that were written down."""
        if self.path.is_file():
            if _ending(self.path) in FORMATS:
                return [self.path], {}
            raise ToolError(f'{self.path}: no recording; allowed: {ALLOWED}')
        there = sorted((file for file in self.path.glob('*') if _ending(file) in FORMATS),
                       key=_by_number)
        names, promised = self._read_metadata()
        listed = [self.path / name for name in names]
        files = [file for file in listed if file.exists()]
        for file in listed:
            if file not in files:
                self._damage.append(f'{file}: is missing, though {METADATA} names it')
        if not files:
            files = there
        for file in there:
            if file not in files:
                self._damage.append(f'{file}: left out, as {METADATA} does not name it')
        if not files:
            raise ToolError(f'{self.path}: no bag there; allowed: {ALLOWED}')
        return files, promised

    def _read_metadata(self) -> tuple[list[str], dict[tuple[str, str], int]]:
        """Return what all versions of the metadata have: names of files, counts of messages."""
        file = self.path / METADATA
        if not file.is_file():
            if self.path.is_dir():
                # The recorder was killed before it wrote it; the data may be whole.
                self._damage.append(f'{self.path}: {METADATA} is missing')
            return [], {}
        try:
            bag = read_metadata(file)
            # Early versions put the folder's name before each file's.
            names = [Path(name).name for name in bag['relative_file_paths']]
            promised: Counter[tuple[str, str]] = Counter()
            for topic in bag['topics_with_message_count']:
                about = topic['topic_metadata']
                promised[about['name'], about['type']] += int(topic['message_count'])
        except BROKEN as error:
            problem = ' '.join(str(error).split()) or type(error).__name__
            self._damage.append(f'{file}: unreadable: {problem}')
            return [], {}
        return names, promised

    def _open(self, file: Path) -> StorageFile:
        """Open a storage file; one that is compressed as a whole is unpacked first."""
        kind = FORMATS[_ending(file)]
        if not is_compressed(file):
            return kind(file)
        if self._unpacked is None:
            self._unpacked = TemporaryDirectory(prefix='screw_kinematics_')
        plain = Path(self._unpacked.name, file.name.removesuffix('.zstd'))
        try:
            with file.open('rb') as source, plain.open('wb') as target:
                unpack_file(source, target)
        except (EOFError, zstd().ZstdError) as error:
            self._damage.append(f'{file}: cut off or broken: {error}')
        return kind(plain)


ALLOWED = ('a directory with files ending in .mcap or .db3, one such file, a .bag of ROS 1, '
           'or a table ending in .csv or .parquet')


BROKEN = (yaml.YAMLError, ValueError, LookupError, TypeError)
"""What looking into metadata raises that are not what they should be."""


def read_metadata(file: Path) -> Any:
    """Return what a bag's ``metadata.yaml`` says of it; raise one of BROKEN, or OSError."""
    return yaml.load(file.read_bytes(), getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
                     )['rosbag2_bagfile_information']


def description_in(recording: Recording, topic: str) -> str | None:
    """Return the last robot description recorded on a topic, if there is one."""
    text = None
    for message in recording.messages({STRING}, {topic}):
        # In CDR: a header of four bytes, the length with the final NUL, the text.
        length = int.from_bytes(message.data[4:8], 'little')
        text = message.data[8:7 + length].decode(errors='replace')
    return text


def full_name(namespace: str, topic: str) -> str:
    """
    Return the full name of a topic.

    Examples
    --------
    >>> full_name('lab', 'joint_states'), full_name('lab', '/joint_states')
    ('/lab/joint_states', '/joint_states')

    """
    if topic.startswith('/'):
        return topic
    return '/'.join(['', *(part for part in (*namespace.split('/'), topic) if part)])


def _ending(file: Path) -> str:
    return Path(file.name.lower().removesuffix('.zstd')).suffix


def _by_number(file: Path) -> list[tuple[int, str]]:
    """Order file names as people do: x_2 before x_10."""
    return [(int(part or 0) if part.isdigit() else -1, part)
            for part in re.split(r'(\d+)', file.name)]

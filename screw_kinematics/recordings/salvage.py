# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages out of damaged storage files: all that stands before, between and after holes."""
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import sqlite3
from typing import Any

from ..errors import MissingExtraError

Found = tuple[str, str, int, bytes]


def salvage(file: Path, damage: list[str]) -> Iterator[Found]:
    """
    Yield topic, type, time of reception [ns] and bytes of the messages in a file.

    Parameters
    ----------
    file : path
        A storage file, ending in .mcap or .db3.
    damage : list of str
        What is found broken is added to it.

    """
    return (_salvage_mcap if file.suffix == '.mcap' else _salvage_sqlite)(file, damage)


def _salvage_mcap(file: Path, damage: list[str]) -> Iterator[Found]:
    """Read records one after another, without the index; skip chunks that are broken."""
    try:
        from mcap.exceptions import McapError
        from mcap.records import Channel, Chunk, Footer, Message, Schema
        from mcap.stream_reader import breakup_chunk, StreamReader
    except ImportError:
        raise MissingExtraError('mcap', 'bag', 'saving messages of a damaged bag') from None
    schemas: dict[int, str] = {}
    channels: dict[int, tuple[str, str]] = {}
    position, ended = 0, False

    def found(record: Any) -> Iterator[Found]:
        if isinstance(record, Schema):
            schemas[record.id] = record.name
        elif isinstance(record, Channel):
            channels[record.id] = (record.topic, schemas.get(record.schema_id, ''))
        elif isinstance(record, Message) and record.channel_id in channels:
            yield (*channels[record.channel_id], record.log_time, record.data)

    with file.open('rb') as stream:
        try:
            for record in StreamReader(stream, emit_chunks=True).records:
                ended = ended or isinstance(record, Footer)
                if not isinstance(record, Chunk):
                    yield from found(record)
                    continue
                try:
                    inside = breakup_chunk(record, validate_crc=True)
                except Exception as error:    # the decompressors have errors of their own
                    damage.append(f'{file}: chunk before byte {stream.tell()} is unreadable: '
                                  f'{type(error).__name__}')
                    continue
                for part in inside:
                    yield from found(part)
        except (McapError, ValueError, LookupError, EOFError, OverflowError,
                MemoryError) as error:
            position = stream.tell()
            damage.append(f'{file}: unreadable from about byte {position}: '
                          f'{type(error).__name__}')
            return
    if not ended:
        damage.append(f'{file}: the recording was not closed')


def _salvage_sqlite(file: Path, damage: list[str]) -> Iterator[Found]:
    """Read the table in the order of recording, beyond pages that are broken."""
    connection = sqlite3.connect(f'file:{file}?mode=ro', uri=True)
    last = 0
    try:
        topics = {number: (name, kind) for number, name, kind in
                  connection.execute('SELECT id, name, type FROM topics')}
        rows = connection.execute('SELECT id, topic_id, timestamp, data FROM messages')
        for last, topic, received, data in rows:
            if topic in topics:
                yield (*topics[topic], received, data)
    except sqlite3.Error as error:
        damage.append(f'{file}: unreadable after message {last}: {error}')
    finally:
        connection.close()

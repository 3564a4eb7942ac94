# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What was recorded on one topic beside the joint states."""
from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from .joint_table import JointTable
from .recording import Recording
from ..errors import MalformedMessageError, ToolError
from ..messages.base_motion import BaseSample
from ..messages.wrench import WrenchSample

Content = TypeVar('Content', BaseSample, WrenchSample)


def samples_on(recording: Recording | JointTable, topic: str,
               readers: Mapping[str, Callable[[bytes], Content]], what: str,
               ) -> Iterator[tuple[int, Content | MalformedMessageError]]:
    """
    Yield when each message of a topic came [ns], and what it says, or why it cannot be read.

    Messages are read by their types, and called ``what`` in errors; those with stamp zero are
    taken to be of the moment they arrived.
    """
    if isinstance(recording, JointTable):
        raise ToolError(f'{recording.path}: a table has no topic {topic}; allowed: a bag')
    some = False
    for message in recording.messages(set(readers), {topic}):
        some = True
        try:
            sample = readers[message.kind](message.data)
        except MalformedMessageError as error:
            yield message.received, error
            continue
        yield message.received, (
            sample if sample.stamp_ns else sample._replace(stamp_ns=message.received))
    if not some:
        there = sorted({c.topic for c in recording.connections if c.kind in readers})
        raise ToolError(f'{recording.path}: no {what} on {topic}; topics of type '
                        f'{", ".join(readers)}: {", ".join(there) or "none"}')

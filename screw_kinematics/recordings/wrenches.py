# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What force sensors have measured, out of recordings."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .joint_table import JointTable
from .recording import Recording
from ..errors import MalformedMessageError, Reason, ToolError
from ..messages.wrench import read_wrench, TYPE, WrenchSample
from ..pipeline.settings import RobotSettings
from ..pipeline.wrench_sensor import WrenchSensor


def recorded_wrenches(recording: Recording | JointTable, topic: str,
                      ) -> Iterator[WrenchSample | Reason]:
    """
    Yield the messages of a topic; for those that cannot be read, why.

    Messages with stamp zero are taken to be of the moment they arrived.

    Raises
    ------
    ToolError
        There is none.

    """
    if isinstance(recording, JointTable):
        raise ToolError(f'{recording.path}: a table has no topic {topic}; allowed: a bag')
    some = False
    for message in recording.messages({TYPE}, {topic}):
        some = True
        try:
            sample = read_wrench(message.data)
        except MalformedMessageError:
            yield Reason.MALFORMED
            continue
        yield sample if sample.stamp_ns else sample._replace(stamp_ns=message.received)
    if not some:
        there = sorted({c.topic for c in recording.connections if c.kind == TYPE})
        raise ToolError(f'{recording.path}: no wrenches on {topic}; topics of type {TYPE}: '
                        f'{", ".join(there) or "none"}')


def recorded_sensor(recording: Recording | JointTable, settings: RobotSettings, model: Any,
                    topic: str) -> WrenchSensor:
    """
    Return a force sensor that knows all that was recorded.

    Raises
    ------
    ToolError
        Nothing was, or all of it is refused.

    """
    sensor = WrenchSensor(settings, kept=True)
    sensor.mount(model)
    for sample in recorded_wrenches(recording, topic):
        if isinstance(sample, Reason):
            sensor.account.close(sample)
        else:
            sensor.take(sample)
    if sensor.pose is None:
        reason, count = sensor.account.refused.most_common(1)[0]
        raise ToolError(f'{recording.path}: {topic}: every wrench is refused: {reason} '
                        f'({sensor.account.details.get(reason) or count})')
    return sensor

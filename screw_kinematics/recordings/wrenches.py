# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What force sensors have measured, out of recordings."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .joint_table import JointTable
from .recording import Recording
from .side_topic import samples_on
from ..errors import MalformedMessageError, Reason, ToolError
from ..messages.wrench import read_wrench, TYPE, WrenchSample
from ..pipeline.settings import RobotSettings
from ..pipeline.wrench_sensor import WrenchSensor


def recorded_wrenches(recording: Recording | JointTable, topic: str,
                      ) -> Iterator[WrenchSample | MalformedMessageError]:
    """Yield the wrenches on a topic, as :func:`.samples_on`."""
    for _, sample in samples_on(recording, topic, {TYPE: read_wrench}, 'wrenches'):
        yield sample


def recorded_sensor(recording: Recording | JointTable, settings: RobotSettings, model: Any,
                    topic: str) -> WrenchSensor:
    """Return a force sensor that knows all that was recorded."""
    sensor = WrenchSensor(settings, kept=True)
    sensor.mount(model)
    for sample in recorded_wrenches(recording, topic):
        if isinstance(sample, MalformedMessageError):
            sensor.account.close(Reason.MALFORMED, str(sample))
        else:
            sensor.take(sample)
    if sensor.pose is None:
        reason, _ = sensor.account.refused.most_common(1)[0]
        raise ToolError(f'{recording.path}: {topic}: every wrench is refused: '
                        f'{sensor.account.told(reason)}')
    return sensor

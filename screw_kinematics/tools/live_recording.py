# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording that is there, or one that is made now of what a running system publishes."""
from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
import time
from typing import Any

from .listener import check_names, Listener
from ..errors import ParameterError, ToolError
from ..pipeline.settings import RobotSettings
from ..recordings.joint_table import JointTable, TableFormat
from ..recordings.recording import full_name, Recording
from ..recordings.sources import opened
from ..recordings.storage import jazzy_types

LONGEST = 3600.0
"""That is listened to a running system [s]."""


def add_options(options: argparse.ArgumentParser) -> None:
    """Add the recording, and how long to listen if there is none."""
    options.add_argument('bag', nargs='?', help='recording of both topics: a folder, or a '
                         '.mcap, .db3 or .bag file (default: listen to the running system)')
    options.add_argument('--seconds', type=float, default=20.0,
                         help='how long to listen (default: 20); let the robot move')


@contextmanager
def recording_of(arguments: argparse.Namespace, robots: Collection[RobotSettings], topic: str,
                 ) -> Iterator[Recording]:
    """Give the recording of the options: the joint states of robots, and another topic."""
    if arguments.bag is not None:
        with opened(arguments.bag, TableFormat()) as recording:
            if isinstance(recording, JointTable):
                raise ParameterError('bag', arguments.bag, 'a bag')
            yield recording
        return
    if not 0 < arguments.seconds <= LONGEST:
        raise ParameterError('seconds', arguments.seconds, f'more than 0, at most {LONGEST:g}')
    descriptions = {full_name(arguments.namespace, robot.description_topic) for robot in robots
                    if not robot.description}
    topics = {full_name(arguments.namespace, name) for robot in robots
              for name in robot.joint_states_topic} | {full_name(arguments.namespace, topic)} | {
        full_name(arguments.namespace, robot.base_motion_topic) for robot in robots
        if robot.relative_to == 'world'}
    with TemporaryDirectory(prefix='screw_kinematics_') as folder:
        path = Path(folder) / 'running_system'
        _listen(path, topics, descriptions, arguments.seconds)
        with Recording(path) as recording:
            yield recording


def _listen(path: Path, topics: Collection[str], of_before: Collection[str], seconds: float,
            ) -> None:
    """Write what comes on some topics into a bag, and on others also what came before."""
    types = jazzy_types('listening to several topics')
    from rosbags.rosbag2 import StoragePlugin, Writer
    with Listener({}, 'screw_kinematics_listener') as listener, Writer(
            path, version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP) as writer:
        check_names('', [*topics, *of_before])

        def writer_of(topic: str, kind: str) -> Callable[[bytes], None]:
            connection = writer.add_connection(topic, kind, typestore=types)
            return lambda data: writer.write(connection, time.time_ns(), data)

        awaited = {*topics, *of_before}
        for _ in listener.listening(seconds):
            for topic, kind in _kinds(listener.node, awaited).items():
                awaited.remove(topic)
                if kind in types.types:     # else it is none that is understood
                    _subscribe(listener.node, topic, kind, topic in of_before,
                               writer_of(topic, kind))
    if awaited:
        raise ToolError(f'nobody publishes {", ".join(sorted(awaited))}; check topic, namespace, '
                        'ROS_DOMAIN_ID and discovery range')


def _kinds(node: Any, topics: Collection[str]) -> Mapping[str, str]:
    """Return the types of those topics that somebody publishes."""
    return {name: kinds[0] for name, kinds in node.get_topic_names_and_types()
            if name in topics and node.count_publishers(name)}


def _subscribe(node: Any, topic: str, kind: str, of_before: bool, take: Callable[[bytes], None],
               ) -> None:
    from ..node.publishers import message_type
    from ..node.qos import input_qos, latched_qos
    node.create_subscription(message_type(kind), topic, take,
                             latched_qos() if of_before else input_qos(), raw=True)

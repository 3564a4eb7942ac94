# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a running ROS system publishes of robots, listened to for a while."""
from __future__ import annotations

from collections.abc import Collection
from functools import partial
import time
from typing import Any, NamedTuple

from rich.console import Console
from rich.progress import Progress

from .findings import FACT, Finding, PROBLEM
from ..listener import check_names, Listener, require_ros
from ...recordings.joint_streams import JointStreams

NODE = 'kinematic_state_publisher'


class Heard(NamedTuple):
    """Joint samples by topic, robot descriptions by topic, and what was found on the way."""

    streams: dict[str, JointStreams]
    descriptions: dict[str, str]
    findings: list[Finding]


def listen(topics: Collection[str], descriptions: Collection[str], seconds: float) -> Heard:
    """
    Listen to joint states and robot descriptions.

    Parameters
    ----------
    topics, descriptions : collection of str
        Full names of topics.
    seconds : float
        How long.

    Raises
    ------
    MissingExtraError, ParameterError
        rclpy is not installed; a topic has no valid name.

    """
    heard = Heard({topic: JointStreams() for topic in topics}, {}, [])
    require_ros()
    check_names('', [*topics, *descriptions])
    with Listener({}, 'check') as listener:
        _subscribe(listener.node, heard, descriptions)
        with Progress(console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task('listening', total=seconds)
            end = time.monotonic() + seconds
            while (left := end - time.monotonic()) > 0:
                listener.listen(min(0.2, left))
                progress.update(task, completed=seconds - max(left, 0))
        heard.findings.extend(_graph(listener.node, topics))
    return heard


def _subscribe(node: Any, heard: Heard, descriptions: Collection[str]) -> None:
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from sensor_msgs.msg import JointState
    from std_msgs.msg import String
    from ...node.topic_inputs import input_qos

    def take(streams: JointStreams, data: bytes) -> None:
        streams.add(time.time_ns(), data)

    def describe(topic: str, message: Any) -> None:
        heard.descriptions[topic] = message.data

    for topic, streams in heard.streams.items():
        node.create_subscription(JointState, topic, partial(take, streams),
                                 input_qos(), raw=True)
    for topic in descriptions:
        node.create_subscription(
            String, topic, partial(describe, topic),
            QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))


def _graph(node: Any, topics: Collection[str]) -> list[Finding]:
    """Return who publishes the topics, and whether the node runs."""
    found = []
    for topic in topics:
        names = [info.node_name for info in node.get_publishers_info_by_topic(topic)]
        if names:
            found.append(Finding(FACT, f'{topic}: published by {", ".join(sorted(names))}'))
        else:
            found.append(Finding(PROBLEM, f'{topic}: nobody publishes it',
                                 'check topic, namespace, ROS_DOMAIN_ID and discovery range'))
    running = sorted(f'{namespace.rstrip("/")}/{name}' for name, namespace
                     in node.get_node_names_and_namespaces() if name == NODE)
    found.append(Finding(FACT, f'{NODE} runs: {", ".join(running) or "no"}'))
    return found

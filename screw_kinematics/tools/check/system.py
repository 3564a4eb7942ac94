# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What a running ROS system publishes of robots, listened to for a while."""
from __future__ import annotations

from collections.abc import Collection
from functools import partial
import time
from typing import Any, NamedTuple

from .findings import FACT, Finding, PROBLEM
from ..listener import check_names, Listener, require_ros
from ...pipeline.parameter_file import NODE_NAME
from ...recordings.joint_streams import JointStreams


class Heard(NamedTuple):
    """Joint samples by topic, robot descriptions by topic, and what was found on the way."""

    streams: dict[str, JointStreams]
    descriptions: dict[str, str]
    findings: list[Finding]


def listen(topics: Collection[str], descriptions: Collection[str], seconds: float) -> Heard:
    """Listen for some seconds to topics of joint states and of robot descriptions."""
    require_ros()
    check_names('', [*topics, *descriptions])
    from sensor_msgs.msg import JointState
    from ...node.qos import input_qos

    def take(samples: JointStreams, data: bytes) -> None:
        samples.add(time.time_ns(), data)

    streams = {topic: JointStreams() for topic in topics}
    with Listener({}, 'check') as listener:
        for topic, samples in streams.items():
            listener.node.create_subscription(JointState, topic, partial(take, samples),
                                              input_qos(), raw=True)
        texts = listener.descriptions(descriptions)
        for _ in listener.listening(seconds):
            pass
        return Heard(streams, texts, _graph(listener.node, topics))


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
                     in node.get_node_names_and_namespaces() if name == NODE_NAME)
    found.append(Finding(FACT, f'{NODE_NAME} runs: {", ".join(running) or "no"}'))
    return found

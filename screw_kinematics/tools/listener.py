# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Listening to topics cheaply: only the newest message of each is ever decoded."""
from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
import time
from typing import Any, TypeVar

import numpy as np
from rich.console import Console
from rich.progress import Progress

from ..errors import optional_module, ParameterError
from ..screws.rotations import rotation_from_quaternion
from ..screws.se3 import Array


This = TypeVar('This', bound='Listener')


class Stream:
    """The newest message of one topic, and how often one comes."""

    _WINDOW = 2.0

    def __init__(self, kind: Any) -> None:
        self._kind = kind
        self._newest = b''
        self._marks: deque[tuple[float, int]] = deque()
        self.count = 0

    def receive(self, message: bytes) -> None:
        """Take a serialised message."""
        self._newest = message
        self.count += 1
        if self.count == 1:
            self._marks.append((time.monotonic(), 1))

    def message(self) -> Any:
        """Return the newest message, or None before the first."""
        from rclpy.serialization import deserialize_message
        return deserialize_message(self._newest, self._kind) if self.count else None

    def rate(self) -> float:
        """Return messages per second over the last two seconds of calls [Hz]."""
        if not self.count:
            return 0.0
        now = time.monotonic()
        self._marks.append((now, self.count))
        while len(self._marks) > 2 and now - self._marks[1][0] > self._WINDOW:
            self._marks.popleft()
        (begin, before), (end, after) = self._marks[0], self._marks[-1]
        return (after - before) / (end - begin) if end > begin else 0.0


class Listener:
    """A ROS node that listens to topics, given with their types, in the present thread."""

    def __init__(self, topics: Mapping[str, Any], name: str, namespace: str = '') -> None:
        require_ros()
        check_names(namespace, topics)
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.qos import qos_profile_sensor_data
        from rclpy.signals import SignalHandlerOptions
        self._context = rclpy.Context()
        rclpy.init(args=[], context=self._context,
                   signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node(name, namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.streams = {topic: Stream(kind) for topic, kind in topics.items()}
        for topic, kind in topics.items():
            self.node.create_subscription(kind, topic, self.streams[topic].receive,
                                          qos_profile_sensor_data, raw=True)

    def __enter__(self: This) -> This:
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    def listen(self, seconds: float) -> None:
        """Receive messages for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def listening(self, seconds: float) -> Iterator[None]:
        """Receive messages for a while, with a bar in the terminal; yield now and then."""
        terminal = Console(stderr=True)
        with Progress(console=terminal, transient=True, disable=not terminal.is_terminal
                      ) as progress:
            task, end = progress.add_task('listening', total=seconds), time.monotonic() + seconds
            while (left := end - time.monotonic()) > 0:
                yield
                self.listen(min(0.2, left))
                progress.update(task, completed=seconds - max(left, 0))

    def descriptions(self, topics: Iterable[str]) -> dict[str, str]:
        """Return the robot descriptions by topic: they are there as soon as they have come."""
        from std_msgs.msg import String
        from ..node.qos import latched_qos
        found: dict[str, str] = {}

        def take(topic: str, message: Any) -> None:
            found[topic] = message.data

        for topic in topics:
            self.node.create_subscription(String, topic, partial(take, topic), latched_qos())
        return found


def stamp_of(message: Any) -> int:
    """Return the stamp of a message with a header [ns]."""
    return int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)


def xyz(vector: Any) -> Array:
    """Return a Vector3 or Point."""
    return np.array([vector.x, vector.y, vector.z])


def six_vector(message: Any) -> Array:
    """Return a Twist or Accel, angular first."""
    return np.concatenate([xyz(message.angular), xyz(message.linear)])


def rotation_of(message: Any) -> Array:
    """Return the rotation matrix of a Quaternion."""
    return rotation_from_quaternion(np.array([message.x, message.y, message.z, message.w]))


def require_ros() -> None:
    """Raise MissingExtraError if ROS cannot be imported."""
    optional_module('rclpy', 'ros', 'talking to ROS')


def check_names(namespace: str, topics: Iterable[str]) -> None:
    """Raise ParameterError for a name that is not valid, of which ROS tells by a traceback."""
    from rclpy.exceptions import NameValidationException
    from rclpy.validate_namespace import validate_namespace
    from rclpy.validate_topic_name import validate_topic_name
    allowed = "letters, digits and '_', in parts that begin with no digit, with '/' between"
    try:
        validate_namespace('/' + namespace.removeprefix('/'))
    except NameValidationException:
        raise ParameterError('namespace', namespace, allowed) from None
    for topic in topics:
        try:
            validate_topic_name(topic)
        except NameValidationException:
            raise ParameterError('topic', topic, allowed) from None

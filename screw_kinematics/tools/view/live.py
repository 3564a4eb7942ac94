# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Robots as the node publishes their states, by the newest message of each topic."""
from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Sequence
from typing import Any

import numpy as np

from .motion import moved, ShownMotion, Snapshot
from .panel import SPAN
from ..listener import check_names, Listener, require_ros, rotation_of, six_vector, stamp_of, xyz
from ...recordings.recording import full_name
from ...screws.body_state import BodyState
from ...screws.rotations import pose
from ...screws.se3 import Array, inverse, rotate

Exact = Callable[[int], BodyState]
"""The true state at an epoch time in ns."""

_REMEMBERED = 64    # joint samples


class LiveRobots(Listener):
    """
    Listens to the node and to the joint states that it gets; appends snapshots to the motions.

    Where a motion has a ``world``, its pose is listened to, which tells where its base is.
    """

    def __init__(self, motions: Sequence[ShownMotion], joint_topics: Sequence[Sequence[str]],
                 namespace: str, exact: Exact | None = None) -> None:
        require_ros()
        from diagnostic_msgs.msg import DiagnosticArray
        from geometry_msgs.msg import AccelStamped, PoseStamped, TwistStamped
        from sensor_msgs.msg import JointState
        topics = {topic: JointState for robot in joint_topics for topic in robot}
        for motion in motions:
            topics[f'{motion.name}/twist'] = TwistStamped
            topics[f'{motion.name}/accel'] = AccelStamped
            if motion.world:
                topics[f'{motion.name}/pose'] = PoseStamped
        topics['/diagnostics'] = DiagnosticArray
        super().__init__(topics, 'screw_kinematics_view', f'/{namespace.strip("/")}')
        self._robots = [_LiveRobot(motion, topics, self, exact)
                        for motion, topics in zip(motions, joint_topics)]

    def listen(self, seconds: float) -> None:
        """Receive messages for a while, and take what is new."""
        super().listen(seconds)
        diagnostics = self.streams['/diagnostics'].message()
        for robot in self._robots:
            robot.take()
            if diagnostics is not None:
                robot.read_doubts(diagnostics)

    def silent(self) -> list[str]:
        """Return the topics on which nothing has come yet, but for the diagnostics."""
        return [topic for topic, stream in self.streams.items()
                if not stream.count and topic != '/diagnostics']


def look_around(namespace: str, topics: Collection[str], seconds: float = 3.0,
                ) -> tuple[list[str], dict[str, str]]:
    """
    Return the robots whose twist and acceleration are published, and descriptions by topic.

    Listens as long as told, or until all descriptions have come.
    """
    require_ros()
    check_names(namespace, topics)
    with Listener({}, 'screw_kinematics_view') as listener:
        found = listener.descriptions(topics)
        for _ in range(round(seconds / 0.1)):
            listener.listen(0.1)
            if topics and len(found) == len(topics):
                break
        names = {name for name, _ in listener.node.get_topic_names_and_types()}
    start = full_name(namespace, 'x')[:-1]
    return sorted(name.removeprefix(start).removesuffix('/twist') for name in names
                  if name.startswith(start) and name.endswith('/twist')
                  and name.removesuffix('twist') + 'accel' in names), found


class _LiveRobot:
    """The newest states of one robot."""

    def __init__(self, motion: ShownMotion, joint_topics: Sequence[str], listener: Listener,
                 exact: Exact | None) -> None:
        self._motion = motion
        self._joints = [listener.streams[topic] for topic in joint_topics]
        outputs = ('twist', 'accel', 'pose') if motion.world else ('twist', 'accel')
        self._states = [listener.streams[f'{motion.name}/{output}'] for output in outputs]
        self._exact = exact
        self._positions: dict[str, float] = {}
        self._samples: deque[tuple[int, Array]] = deque(maxlen=_REMEMBERED)
        self._start: int | None = None

    def take(self) -> None:
        """Take the newest joint positions and states, if there are new ones."""
        names = self._motion.robot.joint_names
        for stream in self._joints:
            message = stream.message()
            if message is not None and len(message.position) == len(message.name):
                self._positions.update(zip(message.name, message.position))
                if all(name in self._positions for name in names):
                    q = np.array([self._positions[name] for name in names])
                    stamp = stamp_of(message)
                    if np.isfinite(q).all() and (
                            not self._samples or stamp > self._samples[-1][0]):
                        self._samples.append((stamp, q))
        states = [stream.message() for stream in self._states]
        if None in states or not self._samples:
            return
        stamp = stamp_of(states[0])
        if any(stamp_of(state) != stamp for state in states):
            return      # another one is still on its way
        if self._start is None:
            self._start = stamp
        time = (stamp - self._start) * 1e-9
        snapshots = self._motion.snapshots
        if snapshots and time < snapshots[-1].time:     # the clock was set back
            snapshots.clear()
        if not snapshots or time > snapshots[-1].time:
            self._motion.append(self._snapshot(time, stamp, *states), SPAN)

    def read_doubts(self, diagnostics: Any) -> None:
        """Take the doubts that the node has about this robot."""
        for status in diagnostics.status:
            robot = status.name.rpartition(': ')[2]
            if f'{self._motion.name}/'.startswith(f'{robot}/'):     # one of several tips, too
                values = {item.key: item.value for item in status.values}
                self._motion.doubts = [doubt for doubt in values.get('doubts', '').split('; ')
                                       if doubt]

    def _snapshot(self, time: float, stamp: int, twist: Any, accel: Any, of_tip: Any = None,
                  ) -> Snapshot:
        q = self._joints_at(stamp)
        robot = self._motion.robot
        tip = seen = robot.state(q).pose
        if of_tip is not None:
            self._motion.world = of_tip.header.frame_id
            seen = pose(rotation_of(of_tip.pose.orientation), xyz(of_tip.pose.position))
        exact, base = None, seen @ inverse(tip)
        if self._exact is not None:
            state = self._exact(stamp)
            exact = np.array([state.classical(1), state.classical(2)])
        return Snapshot(time, q, moved(robot.skeleton(q), base), seen,
                        self._turned(twist.header, six_vector(twist.twist), seen),
                        self._turned(accel.header, six_vector(accel.accel), seen),
                        exact=exact, base=base)

    def _turned(self, header: Any, vectors: Array, tip: Array) -> Array:
        """Return two vectors in the axes of what the tip's pose is relative to."""
        robot = self._motion.robot
        if robot.tip_frame == robot.base_frame or not header.frame_id.endswith(robot.tip_frame):
            return vectors
        return rotate(tip[:3, :3], vectors)

    def _joints_at(self, stamp: int) -> Array:
        """Return the joint positions at an instant, which may be before the newest ones."""
        stamps = np.array([sample[0] for sample in self._samples], dtype=np.int64)
        values = np.array([sample[1] for sample in self._samples])
        at = (stamps - stamps[0]).astype(float)
        return np.array([np.interp(float(stamp - stamps[0]), at, column) for column in values.T])

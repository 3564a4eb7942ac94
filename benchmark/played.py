# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Play a recording of joint states to the real node over DDS, and check what comes back.

At its own pace, with the stamps it has. Every message that the estimator accepts must have its
outputs, for each delay, stamped with the message's stamp less the delay to the nanosecond, and
with the numbers that the library gives for the same messages (but for rounding: times count from
another instant). How good these are is told as by ``python -m benchmark.estimation --recording``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import subprocess
import sys
import tempfile
import threading
import time
from typing import Any

from benchmark.domain import own_domain
from benchmark.estimation.recorded import add_options, prepare, read_stream, samples_of, score
from benchmark.estimation.samples import Result
import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rich.console import Console
from rich.progress import track
from rich.table import Table
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory
import yaml

from screw_kinematics.errors import Reason, ScrewKinematicsError, ToolError
from screw_kinematics.motion import MotionEstimator
from screw_kinematics.recordings.joint_streams import JointStream
from screw_kinematics.tools import table_options

SECOND = 10**9
DELAYS = (0.0, 0.02, 0.05)
NODE = 'import sys; from screw_kinematics.node.main import main; sys.exit(main())'
PATIENCE = 90.0
BEGIN_NS = 1_700_000_000 * SECOND
"""Stamps of a table may begin at zero, which in ROS means that there is none."""

Outputs = dict[int, tuple[list[float], list[float], list[float]]]
"""Positions, velocities and accelerations by stamp [ns]."""


def arm_of(names: Sequence[str]) -> str:
    """Return a description with these joints; only their motion is of interest."""
    links = ''.join(
        f'<link name="l{i}"/><joint name="{name}" type="continuous"><parent link="l{i}"/>'
        f'<child link="l{i + 1}"/><origin xyz="0 0 0.1"/><axis xyz="{i % 2} 0 {1 - i % 2}"/>'
        '</joint>' for i, name in enumerate(names))
    return f'<robot name="recorded">{links}<link name="l{len(names)}"/></robot>'


def parameters(names: Sequence[str]) -> dict[str, Any]:
    """Return a robot for each delay; no message is to be lost on the way to the node."""
    return {'robots': [f'r{i}' for i in range(len(DELAYS))], 'qos_overrides': {
        '/joint_states': {'subscription': {'reliability': 'reliable', 'depth': 1000}}}, **{
        f'r{i}': {'description': arm_of(names), 'outputs': ['joint_motion'],
                  'joint_states_topic': 'joint_states', 'stale_timeout': 60.0,
                  'estimator': {'delay': delay}} for i, delay in enumerate(DELAYS)}}


def messages_of(stream: JointStream, names: Sequence[str]) -> list[JointState]:
    """Return the messages of a stream."""
    columns = [stream.names.index(name) for name in names]
    shift = BEGIN_NS if min(stream.stamps) < SECOND else 0
    messages = []
    for stamp, position, velocity in zip(stream.stamps, stream.positions, stream.velocities):
        message = JointState(name=list(names))
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp + shift, SECOND)
        message.position = [position[c] for c in columns]
        if len(velocity) == len(position):
            message.velocity = [velocity[c] for c in columns]
        messages.append(message)
    return messages


def stamp_ns(message: Any) -> int:
    """Return the stamp of a message."""
    return message.header.stamp.sec * SECOND + message.header.stamp.nanosec


def play(names: Sequence[str], messages: Sequence[JointState], console: Console,
         ) -> list[Outputs]:
    """Play messages to a node; return its outputs by delay."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, 'parameters.yaml')
        file.write_text(yaml.safe_dump({'/**': {'ros__parameters': parameters(names)}}))
        node = rclpy.create_node('played')
        got: list[list[bytes]] = [[] for _ in DELAYS]
        for i in range(len(DELAYS)):
            node.create_subscription(JointTrajectory, f'r{i}/joint_motion', got[i].append,
                                     QoSProfile(depth=4 * len(messages)), raw=True)
        publisher = node.create_publisher(JointState, 'joint_states', QoSProfile(depth=1000))
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        listener = threading.Thread(target=_spin, args=(executor,), daemon=True)
        listener.start()
        process = subprocess.Popen([sys.executable, '-c', NODE, '--ros-args', '--params-file',
                                    str(file)])
        try:
            _wait_until_served(process, publisher, got, messages[0])
            for outputs in got:
                outputs.clear()
            begin, first = time.monotonic(), stamp_ns(messages[0])
            for message in track(messages, 'played', console=console):
                rest = (stamp_ns(message) - first) / SECOND - (time.monotonic() - begin)
                if rest > 0.0:
                    time.sleep(rest)
                publisher.publish(message)
            _wait_until_quiet(got)
        finally:
            process.terminate()
            process.wait(PATIENCE)
            executor.shutdown()
            node.destroy_node()
    return [_decoded(outputs) for outputs in got]


def _spin(executor: SingleThreadedExecutor) -> None:
    try:
        executor.spin()
    except ExternalShutdownException:
        pass


def _wait_until_served(process: subprocess.Popen, publisher: Any, got: list[list[bytes]],
                       like: JointState) -> None:
    """Send what stands still, long before the recording, until all outputs come."""
    limit, stamp = time.monotonic() + PATIENCE, stamp_ns(like) - 1000 * SECOND
    while not all(got):
        if time.monotonic() > limit or process.poll() is not None:
            raise ToolError('the node does not answer')
        still = JointState(name=like.name, position=like.position)
        still.header.stamp.sec, still.header.stamp.nanosec = divmod(stamp, SECOND)
        publisher.publish(still)
        stamp += SECOND // 100
        time.sleep(0.01)
    _wait_until_quiet(got)


def _wait_until_quiet(got: list[list[bytes]]) -> None:
    """Wait until nothing has come for a second."""
    count = -1
    while count != (count := sum(map(len, got))):
        time.sleep(1.0)


def _decoded(outputs: Sequence[bytes]) -> Outputs:
    found: Outputs = {}
    for data in outputs:
        message = deserialize_message(data, JointTrajectory)
        point = message.points[0]
        found[stamp_ns(message)] = (list(point.positions), list(point.velocities),
                                    list(point.accelerations))
    return found


def expected(messages: Sequence[JointState], delay: float) -> tuple[Outputs, dict[int, int]]:
    """Return what the library makes of the messages, and which row led to which stamp [ns]."""
    n = len(messages[0].position)
    estimator = MotionEstimator(n, delay, continuous=[True] * n)
    found: Outputs = {}
    rows = {}
    for k, message in enumerate(messages):
        velocity = message.velocity.tolist() or None
        motion = estimator.step(stamp_ns(message), message.position.tolist(), velocity)
        if not isinstance(motion, Reason):
            found[motion.stamp_ns] = (motion.position.tolist(), motion.velocity.tolist(),
                                      motion.acceleration.tolist())
            rows[stamp_ns(message) - round(delay * SECOND)] = k
    return found, rows


def main(argv: Sequence[str] | None = None) -> int:
    """Run from the command line; return the exit code: 1 if something is missing."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.played', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser)
    table_options.add_options(parser)
    chosen = parser.parse_args(argv)
    if not chosen.recording:
        parser.error('which recording? --recording FILE')
    console = Console(width=None if sys.stdout.isatty() else 120)
    try:
        stream, names = read_stream(chosen)
        messages = messages_of(stream, names)
        with own_domain():
            rclpy.init()
            played = play(names, messages, console)
            rclpy.try_shutdown()
        arm = prepare(*samples_of(stream, names), chosen.cutoff)
    except (ScrewKinematicsError, OSError) as error:
        print(f'{parser.prog}: {error}', file=sys.stderr)
        return 2
    table = Table(title=f'{len(messages)} messages of {len(names)} joints')
    for heading in ('delay', 'accepted', 'with output', 'stamps of no message', 'same numbers',
                    'error over usual practice', 'over the motion', 'largest'):
        table.add_column(heading, justify='right')
    whole = True
    shift = stamp_ns(messages[0])
    for delay, outputs in zip(DELAYS, played):
        should, rows = expected(messages, delay)
        there = [stamp for stamp in outputs if stamp in rows]
        same = sum(np.allclose(outputs[stamp], should[stamp], 1e-6, 1e-6)
                   for stamp in there if stamp in should)
        whole &= len(there) == len(outputs) == len(should) == same
        stamps = sorted(there)
        velocity, acceleration = (np.array([outputs[stamp][k] for stamp in stamps])
                                  for k in (1, 2))
        row = score(arm, Result(np.array([rows[stamp] for stamp in stamps]),
                                (np.array(stamps) - shift) * 1e-9, velocity, acceleration,
                                delay, 0.0))
        table.add_row(f'{1e3 * delay:.0f} ms', str(len(should)), str(len(there)),
                      str(len(outputs) - len(there)), str(same), f"{row['score']:.4f}"
                      f"{'' if row['resolved'] else '~'}", f"{row['relative']:.4f}",
                      f"{row['largest']:.1f}")
    console.print(table)
    return 0 if whole else 1


if __name__ == '__main__':
    sys.exit(main())

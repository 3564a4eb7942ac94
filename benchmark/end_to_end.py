# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Error of the tip's linear acceleration, from the real node over DDS, against the truth.

A PUMA and a Panda swing smoothly; their encoders are read at 500 Hz in steps of 1e-5 rad. Every
way of estimating is a robot of one node; errors are those at the instant each output is stamped
with. Samples carry the stamps of a regular clock, and are sent as fast as the node takes them.
"""
import argparse
import subprocess
import sys
import time

from benchmark.domain import own_domain
from benchmark.swinging import swing
from geometry_msgs.msg import AccelStamped
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rich.console import Console
from rich.table import Table
from screw_kinematics import models
from sensor_msgs.msg import JointState

PERIOD_NS, ENCODER_STEP, VELOCITY_NOISE = 2_000_000, 1e-5, 1e-3
BEGIN_NS = 1_700_000_000 * 10**9
SETTLE = 500
"""Samples that are not scored."""

WINDOW, PATIENCE = 30, 90.0
NODE = 'import sys; from screw_kinematics.node.main import main; sys.exit(main())'
CONFIG = 'package://screw_kinematics/config/robots/'
CASES = [(robot, delay, velocity) for robot in ('puma560', 'panda')
         for delay in (0.0, 0.02) for velocity in (False, True)]


def motion(n: int, t: np.ndarray, seed: int) -> list[np.ndarray]:
    """Return positions, velocities and accelerations: sines of 0.2 to 1.4 Hz."""
    return swing(t, n, np.random.default_rng(seed), ((0.2, 0.4), (0.6, 0.13), (1.4, 0.05)))


def latest(found: dict) -> int:
    """Return the stamp of the latest output."""
    return next(reversed(found), -1)


def run(samples: int, seed: int) -> list[tuple[float, float, int]]:
    """Return for each case RMS error, RMS of the truth (m/s^2), and the outputs scored."""
    node = rclpy.create_node('end_to_end')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    outputs: list[dict[int, tuple[float, float, float]]] = [{} for _ in CASES]
    publishers = []
    arguments = [f'robots:=[{", ".join(f"r{i}" for i in range(len(CASES)))}]']
    for i, (robot, delay, _) in enumerate(CASES):
        arguments += [f'r{i}.description:={CONFIG}{robot}.yaml', f'r{i}.outputs:=[accel]',
                      f'r{i}.joint_states_topic:=r{i}/joint_states',
                      f'r{i}.estimator.delay:={delay}']
        publishers.append(node.create_publisher(JointState, f'r{i}/joint_states', 100))

        def take(message: AccelStamped, found: dict = outputs[i]) -> None:
            stamp, linear = message.header.stamp, message.accel.linear
            at = stamp.sec * 10**9 + stamp.nanosec - BEGIN_NS
            found[at] = linear.x, linear.y, linear.z
        node.create_subscription(AccelStamped, f'r{i}/accel', take, QoSProfile(depth=1000))
    process = subprocess.Popen([sys.executable, '-c', NODE, '--ros-args', *(
        word for argument in arguments for word in ('-p', argument))])
    try:
        deadline = time.monotonic() + PATIENCE
        while not all(p.get_subscription_count() for p in publishers):
            executor.spin_once(0.05)
            if time.monotonic() > deadline or process.poll() is not None:
                raise RuntimeError('the node does not listen')
        random = np.random.default_rng(seed)
        t = np.arange(samples) * PERIOD_NS * 1e-9
        chains = [models.load(f'{CONFIG}{robot}.yaml') for robot, _, _ in CASES]
        truths = [motion(chain.dof, t, seed) for chain in chains]
        for k in range(samples):
            seconds, nanoseconds = divmod(BEGIN_NS + k * PERIOD_NS, 10**9)
            for (_, _, velocity), chain, (q, qd, _), publisher in zip(
                    CASES, chains, truths, publishers):
                message = JointState(name=list(chain.joint_names))
                message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
                message.position = (np.round(q[k] / ENCODER_STEP) * ENCODER_STEP).tolist()
                if velocity:
                    noise = random.normal(0, VELOCITY_NOISE, chain.dof)
                    message.velocity = (qd[k] + noise).tolist()
                publisher.publish(message)
            # Neither side falls behind: no more than a window is under way.
            limit = time.monotonic() + (0.2 if k > WINDOW else 0.01)
            while time.monotonic() < limit and (
                    min(map(latest, outputs)) < (k - WINDOW) * PERIOD_NS):
                executor.spin_once(0.01)
        limit = time.monotonic() + 2.0
        while time.monotonic() < limit:
            executor.spin_once(0.05)
    finally:
        process.terminate()
        process.wait(PATIENCE)
        node.destroy_node()
    rows = []
    for found, chain in zip(outputs, chains):
        at = np.array([stamp for stamp in sorted(found) if stamp > SETTLE * PERIOD_NS])
        got = np.array([found[stamp] for stamp in at.tolist()])
        truth = chain.state(*motion(chain.dof, at * 1e-9, seed)).classical(2)[:, 3:]
        rows.append((float(np.sqrt(np.mean(((got - truth)**2).sum(axis=1)))),
                     float(np.sqrt(np.mean((truth**2).sum(axis=1)))), len(at)))
    return rows


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(
        prog='python -m benchmark.end_to_end', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--seconds', type=float, default=6.0, help='of motion')
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    with own_domain():
        rclpy.init()
        rows = run(round(options.seconds * 1e9 / PERIOD_NS), options.seed)
        rclpy.try_shutdown()
    table = Table('robot', 'delay', 'velocity', 'RMS error m/s²', 'RMS of the truth', 'outputs')
    for (robot, delay, velocity), (error, truth, count) in zip(CASES, rows):
        table.add_row(robot, f'{delay * 1e3:.0f} ms', 'measured' if velocity else 'none',
                      f'{error:.4f}', f'{truth:.2f}', str(count))
    Console(width=100).print(table)


if __name__ == '__main__':
    main()

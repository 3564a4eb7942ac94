# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A subscriber of all outputs, also of a relay's, to be stopped while it has messages to take.

Arguments: its reliability, and a file that it makes once it has got a message.
"""
from pathlib import Path
import sys

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy

from .robots import KINDS, RELAYED, ROBOTS


def main() -> None:
    """Subscribe, and read whatever comes."""
    reliability, listening = sys.argv[1:]
    rclpy.init(args=[])
    node = rclpy.create_node('stalling')
    qos = QoSProfile(depth=10, reliability=ReliabilityPolicy[reliability.upper()])
    got: list[bytes] = []
    for robot in ROBOTS:
        for output in robot.outputs:
            for prefix in ('', RELAYED):
                node.create_subscription(
                    KINDS[output], f'{prefix}{robot.name}/{output}', got.append, qos, raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    while rclpy.ok() and not got:
        executor.spin_once(0.1)
    Path(listening).touch()
    while rclpy.ok():
        executor.spin_once(0.1)
        got.clear()


if __name__ == '__main__':
    main()

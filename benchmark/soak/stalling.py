# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A subscriber of all outputs, also of a relay's, to be stopped while it has messages to take."""
import rclpy
from rclpy.experimental import EventsExecutor

from .robots import KINDS, RELAYED, ROBOTS


def main() -> None:
    """Subscribe, and read whatever comes."""
    rclpy.init(args=[])
    node = rclpy.create_node('stalling')
    for robot in ROBOTS:
        for output in robot.outputs:
            for prefix in ('', RELAYED):
                node.create_subscription(KINDS[output], f'{prefix}{robot.name}/{output}',
                                         lambda _: None, 10, raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    while rclpy.ok():
        executor.spin_once(0.1)


if __name__ == '__main__':
    main()

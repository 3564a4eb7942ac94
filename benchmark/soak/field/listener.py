# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A reliable subscriber of all outputs, to be stopped; says on standard output that it listens."""
import sys

import rclpy
from rclpy.qos import QoSProfile

from .rig import KINDS
from .robots import OUTPUTS, ROBOTS


def main() -> None:
    """Subscribe, and read whatever comes."""
    rclpy.init(args=[])
    node = rclpy.create_node('listener')
    got: list[bytes] = []
    for robot in ROBOTS[:int(sys.argv[1])]:
        for output in OUTPUTS:
            node.create_subscription(KINDS[output], f'{robot.name}/{output}', got.append,
                                     QoSProfile(depth=10), raw=True)
    while rclpy.ok() and not got:
        rclpy.spin_once(node)
    print('listening', flush=True)
    while rclpy.ok():
        rclpy.spin_once(node)
        got.clear()


if __name__ == '__main__':
    main()

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A bare node with the topics of the real one: what the middleware needs under the same faults."""
from collections.abc import Callable, Sequence

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from .robots import INPUT_DEPTH, KINDS, OUTPUT_DEPTH, RELAYED, ROBOTS

_HEAD, _REST = b'\0\1\0\0', b'\1\0\0\0\0\0\0\0' + bytes(6 * 8)


def copy_stamps(publishers: Sequence[Callable[[bytes], None]]) -> Callable[[bytes], None]:
    """Return a callback that publishes zeros with the stamp of what it gets."""
    def callback(data: bytes) -> None:
        for publish in publishers:
            publish(_HEAD + data[4:12] + _REST)
    return callback


def main() -> None:
    """Relay the joint states of all robots."""
    rclpy.init(args=[])
    node = rclpy.create_node('relay')
    for robot in ROBOTS:
        publishers = [node.create_publisher(
            KINDS[output], f'{RELAYED}{robot.name}/{output}', QoSProfile(depth=OUTPUT_DEPTH),
            ).publish for output in robot.outputs]
        node.create_subscription(JointState, f'{robot.name}/joint_states',
                                 copy_stamps(publishers), QoSProfile(depth=INPUT_DEPTH), raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    while rclpy.ok():
        executor.spin_once(0.1)


if __name__ == '__main__':
    main()

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
A publisher of joint states in its own process, which may be killed.

Usage: joint_source.py TOPIC RATE FIRST_STAMP_NS JOINT... Waits for a subscription, then
publishes at the rate, with stamps one period apart, until it is ended.
"""
import sys
import time

import rclpy
from sensor_msgs.msg import JointState
from rig import joint_state, KEEP, smooth_motion


def main(topic, rate, first, *names):
    """Publish."""
    rclpy.init(args=[])
    node = rclpy.create_node('source')
    publisher = node.create_publisher(JointState, topic, KEEP)
    while publisher.get_subscription_count() == 0:
        time.sleep(0.01)
    period = 1.0 / float(rate)
    k, due = 0, time.monotonic()
    while True:
        q, qd = smooth_motion(len(names), k * period)
        publisher.publish(joint_state(names, int(first) + round(k * period * 1e9), q, qd))
        k += 1
        due += period
        time.sleep(max(0.0, due - time.monotonic()))


if __name__ == '__main__':
    main(*sys.argv[1:])

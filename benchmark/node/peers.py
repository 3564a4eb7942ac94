# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Other nodes for comparison: from joint states to a twist and an acceleration.

Run one with `python -m benchmark.node.peers KIND ROBOTS`. Each robot r0, r1, ... has its own
topic of joint states, as in all of this benchmark.
"""
from collections.abc import Callable
import sys
from typing import Any

from geometry_msgs.msg import AccelStamped, TwistStamped
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from screw_kinematics.node import fast_dds
from sensor_msgs.msg import JointState

from .robot import BASE, JOINTS, TIP, URDF

Compute = Callable[[JointState], tuple[Any, Any]]


def relay(node: Node, robot: str) -> None:
    """Copy the header, compute nothing: what rclpy itself costs."""
    publish_both(node, robot, lambda message: ([0.0] * 6, [0.0] * 6))


def pinocchio(node: Node, robot: str) -> None:
    """Forward kinematics by Pinocchio, accelerations of the joints taken as zero."""
    import numpy as np
    import pinocchio as pin

    full = pin.buildModelFromUrdf(str(URDF))
    fixed = [full.getJointId(name) for name in full.names[1:] if name not in JOINTS]
    model = pin.buildReducedModel(full, fixed, pin.neutral(full))
    data = model.createData()
    tip = model.getFrameId(TIP)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    at_rest = np.zeros(model.nv)
    place = {name: i for i, name in enumerate(model.names[1:])}

    def compute(message: JointState) -> tuple[list[float], list[float]]:
        q, v = np.empty(model.nq), np.empty(model.nv)
        for name, position, velocity in zip(message.name, message.position, message.velocity):
            i = place[name]
            q[i], v[i] = position, velocity
        pin.forwardKinematics(model, data, q, v, at_rest)
        twist = pin.getFrameVelocity(model, data, tip, axes)
        accel = pin.getFrameClassicalAcceleration(model, data, tip, axes)
        return twist.vector.tolist(), accel.vector.tolist()

    publish_both(node, robot, compute)


def numpy(node: Node, robot: str) -> None:
    """Joint transforms and Jacobian by hand; accelerations by differences of two samples."""
    from .handwritten import HandwrittenKinematics
    publish_both(node, robot, HandwrittenKinematics().update)


def publish_both(node: Node, robot: str, compute: Compute) -> None:
    """Subscribe as most nodes do; compute returns two vectors, linear first."""
    twist_publisher = node.create_publisher(TwistStamped, f'{robot}/twist', 10)
    accel_publisher = node.create_publisher(AccelStamped, f'{robot}/accel', 10)

    def callback(message: JointState) -> None:
        velocity, acceleration = compute(message)
        twist, accel = TwistStamped(), AccelStamped()
        for out, vector, values in ((twist, twist.twist, velocity),
                                    (accel, accel.accel, acceleration)):
            out.header.stamp = message.header.stamp
            out.header.frame_id = BASE
            vector.linear.x, vector.linear.y, vector.linear.z = values[:3]
            vector.angular.x, vector.angular.y, vector.angular.z = values[3:]
        twist_publisher.publish(twist)
        accel_publisher.publish(accel)

    node.create_subscription(JointState, f'{robot}/joint_states', callback, 100)


def raw_relay(node: Node, robot: str) -> None:
    """Copy the stamp from bytes to bytes, with our middleware settings: the floor in Python."""
    twist, accel = (
        node.create_publisher(kind, f'{robot}/{name}', 10).handle.publish_raw
        for kind, name in ((TwistStamped, 'twist'), (AccelStamped, 'accel')))
    head, rest = b'\0\1\0\0', b'\1\0\0\0\0\0\0\0' + bytes(6 * 8)

    def callback(data: bytes) -> None:
        out = head + data[4:12] + rest
        twist(out)
        accel(out)

    node.create_subscription(JointState, f'{robot}/joint_states', callback, 100, raw=True)


KINDS = {'relay': relay, 'pinocchio': pinocchio, 'numpy': numpy, 'raw_relay': raw_relay}


def main() -> None:
    """Run one kind of node for some robots."""
    kind, robots = sys.argv[1], int(sys.argv[2])
    if kind == 'raw_relay':
        fast_dds.settle()
    rclpy.init()
    node = rclpy.create_node(kind)
    for i in range(robots):
        KINDS[kind](node, f'r{i}')
    try:
        if kind == 'raw_relay':
            from rclpy.experimental import EventsExecutor
            executor = EventsExecutor()
            executor.add_node(node)
            end = Future()
            while rclpy.ok():       # one spin for many events; a spin for each costs 12 us more
                executor.spin_until_future_complete(end, 1.0)
        else:
            rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == '__main__':
    main()

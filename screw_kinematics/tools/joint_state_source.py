# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A JointState publisher that moves a robot by a reference motion, like a driver would."""
from __future__ import annotations

import argparse
from array import array
from collections.abc import Sequence
import time

from . import console, robot_options
from .listener import check_names
from .reference_motions import MOTIONS
from ..errors import MissingExtraError, ParameterError
from ..node.stop_request import StopRequest

EXAMPLES = """\
  joint_state_source                            the paper's PUMA motion, 100 Hz
  joint_state_source --motion minjerk --rate 1000
  joint_state_source --robot panda.urdf --tip panda_hand_tcp --topic /joint_states
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``joint_state_source --help``."""
    options = console.parser('joint_state_source', __doc__ or '', EXAMPLES)
    robot_options.add_options(options, default=robot_options.PUMA)
    add_motion_options(options)
    options.add_argument('--topic', default='joint_states', help='default: joint_states')
    options.add_argument('--namespace', default='', help='ROS namespace of the topic')
    options.add_argument('--start', type=int, metavar='NANOSECONDS',
                         help='epoch time at which the motion began (default: now)')
    return console.run(publish, options, argv)


def add_motion_options(options: argparse.ArgumentParser) -> None:
    """Add the choice of a motion and of its rate."""
    options.add_argument('--motion', choices=MOTIONS, default='paper',
                         help="the paper's sinusoids (default), minimum-jerk moves to and "
                              'fro, or five sinusoids of 0.1 to 2 Hz')
    options.add_argument('--rate', type=float, default=100.0, metavar='HZ',
                         help='joint states per second (default: 100)')


def checked_rate(rate: float) -> float:
    """Return the rate [Hz]; raise ParameterError if it is none."""
    if not 0 < rate <= 10_000:
        raise ParameterError('rate', rate, 'more than 0, at most 10000 Hz')
    return rate


def publish(arguments: argparse.Namespace) -> int:
    """
    Publish positions and velocities until a signal comes.

    Samples lie on a regular clock that began with the motion, as those of a controller
    do; instants that were missed are left out, not made up for in a burst.
    """
    try:
        import rclpy
        from rclpy.signals import SignalHandlerOptions
        from sensor_msgs.msg import JointState
    except ImportError:
        raise MissingExtraError('rclpy', 'ros', 'publishing joint states') from None
    rate = checked_rate(arguments.rate)
    check_names(arguments.namespace, [arguments.topic])
    stop = StopRequest()
    stop.take_signals()
    robot = robot_options.load(arguments)
    motion = robot_options.motion(robot, arguments.motion)
    start = time.time_ns() if arguments.start is None else arguments.start
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node('joint_state_source', namespace=arguments.namespace)
        publisher = node.create_publisher(JointState, arguments.topic, 10)
        message = JointState(name=list(robot.joint_names))
        tick = -1
        while not stop.made:
            # An instant is kept if it is less than one period late.
            tick = max(tick + 1, int((time.time_ns() - start) * 1e-9 * rate))
            elapsed = round(tick / rate * 1e9)
            # Short naps, so that a signal is answered soon at low rates too.
            while (wait := (start + elapsed - time.time_ns()) * 1e-9) > 0 and not stop.made:
                time.sleep(min(wait, 0.1))
            position, velocity = motion.derivatives(elapsed * 1e-9, 1)
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(
                start + elapsed, 1_000_000_000)
            message.position = array('d', position)
            message.velocity = array('d', velocity)
            publisher.publish(message)
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return console.OK


if __name__ == '__main__':
    raise SystemExit(main())

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A JointState publisher that moves a robot by a reference motion, like a driver would."""
from __future__ import annotations

import argparse
from array import array
from collections.abc import Sequence
from functools import partial
import sys
import time
from typing import Any

from .. import console, robot_options
from ..listener import check_names
from ..reference_motions import MOTIONS, ReferenceMotion
from ..stamping import help_text, stampings, WAYS
from ...errors import InvalidValueError, MissingExtraError, ParameterError
from ...node.main import initialise
from ...node.stop_request import StopRequest

EXAMPLES = """\
  joint_state_source                            the paper's PUMA motion, 100 Hz
  joint_state_source --motion minjerk --rate 1000
  joint_state_source --rate 500 --stamps reader  a loop beside a 1 kHz device
  joint_state_source --robot panda.urdf --tip panda_hand_tcp --topic /joint_states
  joint_state_source --ros-args -r __ns:=/cell -r joint_states:=measured
"""

LATEST = 2**31 * 10**9
"""Beyond it is no stamp of a message [ns]."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``joint_state_source --help``."""
    options = console.parser('joint_state_source', f'{__doc__}\n\nways of stamping:\n'
                             + help_text(), EXAMPLES)
    robot_options.add_options(options, default=robot_options.PUMA)
    add_motion_options(options)
    options.add_argument('--topic', default='joint_states',
                         help='topic to publish on (default: joint_states)')
    options.add_argument('--namespace', default='', help='ROS namespace of the topic')
    options.add_argument('--start', type=int, metavar='NANOSECONDS',
                         help='epoch time at which the motion began (default: now)')
    words = list(sys.argv[1:] if argv is None else argv)
    return console.run(partial(publish, ros_arguments=words), options, words)


def add_motion_options(options: argparse.ArgumentParser) -> None:
    """Add the choice of a motion and of its rate."""
    options.add_argument('--motion', choices=MOTIONS, default='paper',
                         help="the paper's sinusoids (default), minimum-jerk moves to and "
                              'fro, or five sinusoids of 0.1 to 2 Hz')
    options.add_argument('--rate', type=float, default=100.0, metavar='HZ',
                         help='joint states per second (default: 100)')
    options.add_argument('--stamps', choices=WAYS, default='exact',
                         help='how readings are stamped (default: exact); '
                              'joint_state_source --help tells what each way does')


def check_rate(rate: float) -> None:
    """Raise ParameterError if that is no rate [Hz]."""
    if not 0 < rate <= 10_000:
        raise ParameterError('rate', rate, 'more than 0, at most 10000 Hz')


def publish(arguments: argparse.Namespace, ros_arguments: Sequence[str] = ()) -> int:
    """Publish positions and velocities until a signal comes; ROS finds its own arguments."""
    try:
        import rclpy
        from rclpy.exceptions import ParameterException
    except ImportError:
        raise MissingExtraError('rclpy', 'ros', 'publishing joint states') from None
    check_rate(arguments.rate)
    if arguments.start is not None and not 0 <= arguments.start < LATEST:
        raise ParameterError('start', arguments.start, f'0 to {LATEST:g} ns since 1970')
    check_names(arguments.namespace, [arguments.topic])
    stop = StopRequest()
    stop.take_signals()
    robot = robot_options.load(arguments)
    motion = robot_options.motion(robot, arguments.motion)
    initialise(['joint_state_source', *ros_arguments])
    try:
        try:
            node = rclpy.create_node('joint_state_source', namespace=arguments.namespace)
        except ParameterException as error:
            raise InvalidValueError(str(error)) from None
        _play(node, arguments, robot.joint_names, motion, stop)
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return console.OK


def _play(node: Any, arguments: argparse.Namespace, names: Sequence[str],
          motion: ReferenceMotion, stop: StopRequest) -> None:
    """
    Publish the motion of joints.

    Readings lie on a regular clock that began with the motion, as those of a controller do,
    and are stamped in the way that was chosen; messages that were missed are left out, not
    made up for in a burst.
    """
    from rclpy import spin_once
    from sensor_msgs.msg import JointState
    publisher = node.create_publisher(JointState, arguments.topic, 10)
    message = JointState(name=list(names))
    simulated = node.get_parameter('use_sim_time').value

    def now() -> int:
        return int(node.get_clock().now().nanoseconds)

    while simulated and not now() and not stop.made:
        spin_once(node, timeout_sec=0.1)
    start = now() if arguments.start is None else arguments.start
    begin = max((now() - start) * 1e-9, 0.0)
    for reading, stamp, sent in stampings(arguments.stamps, arguments.rate, begin):
        if stop.made:
            break
        if (now() - start) * 1e-9 - sent > 1 / arguments.rate:
            continue    # a period late and more
        while (wait := sent - (now() - start) * 1e-9) > 0 and not stop.made:
            # Short naps, so that a signal is answered soon at low rates too.
            if simulated:
                spin_once(node, timeout_sec=0.1)
            else:
                time.sleep(min(wait, 0.1))
        position, velocity = motion.derivatives(reading, 1)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(
            start + round(stamp * 1e9), 1_000_000_000)
        message.position = array('d', position)
        message.velocity = array('d', velocity)
        publisher.publish(message)


if __name__ == '__main__':
    raise SystemExit(main())

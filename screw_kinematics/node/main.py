# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Entry point of the node: `ros2 run screw_kinematics kinematic_state_publisher`.

Ends with code 0 on SIGINT and SIGTERM, and with code 1 and one line on standard error where
it cannot start.
"""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
import os
import sys
from typing import NoReturn, TYPE_CHECKING

# Nothing that takes long is imported before the signals are taken.
from .stop_request import StopRequest
from ..errors import InvalidValueError, MissingExtraError, optional_module, ScrewKinematicsError

if TYPE_CHECKING:
    from .node import Before

NAME = 'kinematic_state_publisher'

SWITCH_INTERVAL = 2e-4
"""Longest time [s] for which a thread that compiles keeps others waiting; Python's own, 5 ms for
each message, would fill the queue of the joint states."""

EXAMPLES = f"""
examples:
  ros2 run screw_kinematics {NAME} --ros-args --params-file FILE.yaml
  ros2 run screw_kinematics {NAME} --ros-args -p robots:=[arm] \\
      -p arm.description:=package://screw_kinematics/config/robots/puma560.yaml
"""


def main(args: Sequence[str] | None = None) -> int:
    """
    Run the node until it is asked to stop; return the exit code.

    The arguments, the program's name first, are by default those of the process.
    """
    with StopRequest() as stop:
        try:
            run(list(sys.argv if args is None else args), stop)
        except ScrewKinematicsError as error:
            print(f'{NAME}: {error}', file=sys.stderr)
            return 1
    return 0


def run(args: list[str], stop: StopRequest) -> None:
    """
    Run the node until a stop is requested; anew where the middleware has left it deaf.

    Raise ScrewKinematicsError if it cannot start as asked.
    """
    check_arguments(without_ros_arguments(args[1:]))
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        # Imported here, since it takes a while in which a signal may come, too.
        import rclpy
        from .node import Before
    except ImportError:
        raise MissingExtraError('rclpy', 'ros', 'running the node') from None
    before: Before | None = None
    try:
        while not stop.made:
            initialise(args)
            before = live(before, stop)
            if stop.made or not stop.again:
                if stop.again or before.diagnostics.times_deaf:
                    end_at_once(before)
                break
            rclpy.try_shutdown()
            stop.again = False
    finally:
        if before is not None:
            before.end()
        rclpy.try_shutdown()


def end_at_once(before: Before) -> NoReturn:
    """
    Destroy the node and end the process, without taking the middleware apart.

    Where its ports had been deleted, 2 of some 50 processes ended with a segmentation fault: Fast
    DDS 2.14, as it closes a port (SharedMemChannelResource::release), locks what is mapped no
    more, perhaps since another thread is making the port anew.
    """
    before.node.destroy_node()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def live(before: Before | None, stop: StopRequest) -> Before:
    """
    Run one node, as far as one before it had come; return how far it has.

    Raise ScrewKinematicsError if it cannot start as asked.
    """
    from rclpy.exceptions import ParameterException
    from .executor import make_executor, spin
    from .node import KinematicStatePublisher
    try:
        with let_go(before):
            node = KinematicStatePublisher(before, stop.begin_again)
    except ParameterException as error:
        # Those that are ROS's own, such as use_sim_time.
        raise InvalidValueError(str(error)) from None
    executor = make_executor(node.get_parameter('executor').value, node.context)
    executor.add_node(node)
    spin(executor, stop)
    executor.shutdown()
    return node.hand_over()


@contextmanager
def let_go(before: Before | None) -> Iterator[None]:
    """
    Let go of a node that was left deaf, and then have another one made in its place.

    It gives its ports back. Were that before this process has joined the middleware anew, it would
    be given the same ones, while others still know them. Were it after the other one is made, rcl,
    which knows nodes by name, would take the publisher of its log for that of the old one.
    """
    if before is None:
        yield
        return
    import rclpy
    from rclpy.parameter import Parameter
    # One without services, which a security policy would have to allow.
    joined = rclpy.create_node(
        f'{NAME}_joining', use_global_arguments=False, enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[Parameter('start_type_description_service', value=False)])
    try:
        before.node.leave()
        yield
    finally:
        joined.destroy_node()


def initialise(args: list[str]) -> None:
    """
    Start ROS, with our settings of the middleware and without its signal handlers.

    Raises
    ------
    MissingExtraError
        rclpy cannot be imported.
    InvalidValueError
        Arguments of ROS are wrong, or it cannot write its logs.

    """
    rclpy = optional_module('rclpy', 'ros', 'running a node')
    from rclpy.signals import SignalHandlerOptions
    from . import fast_dds
    fast_dds.settle()
    import locale
    # ROS reads numbers of parameters as the locale writes them.
    locale.setlocale(locale.LC_NUMERIC, 'C')
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        import re
        # Without the places in the middleware's own source code.
        problem = re.sub(r',? at \S+:\d+', '', ' '.join(str(error).split()))
        if 'log directory' in problem:
            raise InvalidValueError(
                f'ROS: {problem}; let ROS_LOG_DIR name a folder that can be written') from None
        raise InvalidValueError(f'ROS arguments: {problem}') from None


def without_ros_arguments(args: Sequence[str]) -> list[str]:
    """Return arguments without those of ROS, which launch files add: ``--ros-args ... [--]``."""
    own, ros = [], False
    for word in args:
        if word == '--ros-args':
            ros = True
        elif ros:
            ros = word != '--'
        else:
            own.append(word)
    return own


def check_arguments(args: Sequence[str]) -> None:
    """Exit with the help text, or with an error: all else is said by parameters."""
    import argparse
    import textwrap
    from .. import __version__, core
    from ..pipeline.setting import Setting
    from ..pipeline.settings import NODE, ROBOT

    def described(settings: Iterable[Setting], prefix: str = '') -> str:
        return '\n'.join(
            textwrap.fill(f'{setting.text} Allowed: {setting.allowed}. '
                          f'Default: {setting.default!r}.', 88,
                          initial_indent=f'  {prefix}{setting.name}: ',
                          subsequent_indent=' ' * 6)
            for setting in settings)

    parser = argparse.ArgumentParser(
        prog=NAME, formatter_class=argparse.RawDescriptionHelpFormatter,
        usage='%(prog)s [-h] [--ros-args ...]',
        description='Publishes twist, acceleration and more of end effectors, from joint states.',
        epilog=f'parameters:\n{described(NODE)}\n\n'
               f'parameters of each robot:\n{described(ROBOT, "<robot>.")}\n{EXAMPLES}')
    parser.add_argument('--version', action='version',
                        version=f'%(prog)s {__version__}; {core.build()}')
    parser.parse_args(args)


if __name__ == '__main__':
    sys.exit(main())

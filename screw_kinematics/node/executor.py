# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The loop in which the node's callbacks run.

It makes bounded steps, so that Python sees a signal within one of them: executors wait
inside C++, where Python's signal handlers do not run.
"""
from __future__ import annotations

from functools import partial

from rclpy.context import Context
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.logging import get_logger
from rclpy.task import Future

from .stop_request import StopRequest
from ..pipeline.parameter_file import NODE_NAME

STEP = 1.0
"""Length of a step [s]: the longest delay of a signal while no callback runs. The node's own
timers let Python see one sooner, so short steps would only cost idle time."""


def make_executor(kind: str, context: Context) -> Executor:
    """Return the executor of that name; the default one where ROS has no events executor."""
    if kind == 'events':
        try:
            from rclpy.experimental import EventsExecutor
        except ImportError:
            pass
        else:
            return EventsExecutor(context=context)
    return SingleThreadedExecutor(context=context)


def spin(executor: Executor, stop: StopRequest) -> None:
    """
    Run callbacks until a stop or a new beginning is requested, or the middleware is shut down.

    What comes out of a step is logged, and the next one begins: a message that the middleware
    cannot read must not end the node.
    """
    executor.context.on_shutdown(stop.middleware_ended)
    # The events executor installs its own signal handlers when it is made.
    stop.take_signals()
    steps = _steps if isinstance(executor, SingleThreadedExecutor) else _long_steps
    while not (stop.made or stop.again):
        try:
            steps(executor, stop)
        except ExternalShutdownException:
            break
        except Exception as error:
            problem = ' '.join(str(error).split()) or type(error).__name__
            get_logger(NODE_NAME).error(f'passed over: {problem}', throttle_duration_sec=1.0)
    stop.interrupt = None


def _steps(executor: Executor, stop: StopRequest) -> None:
    while not (stop.made or stop.again):
        executor.spin_once(STEP)


def _long_steps(executor: Executor, stop: StopRequest) -> None:
    """Spin in steps of many events, which costs less than a step for each."""
    while not (stop.made or stop.again):
        end = Future()
        # While messages keep coming a step outlasts its time: only its future ends it. The
        # executor sets it, as a signal may come in the middle of any work on the future.
        stop.interrupt = partial(executor.create_task, end.set_result, None)
        executor.spin_until_future_complete(end, STEP)

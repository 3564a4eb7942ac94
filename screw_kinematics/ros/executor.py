# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The loop in which the node's callbacks run.

It makes bounded steps, so that Python sees a signal within one of them: executors wait
inside C++, where Python's signal handlers do not run.
"""
from __future__ import annotations

from rclpy.context import Context
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor

from .stop_request import StopRequest

EXECUTORS = ('events', 'single_threaded')
"""Choices: ROS's events executor where it exists, or its default one."""

STEP = 0.1
"""Longest wait in one step [s], and so the longest delay of a signal."""


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
    """Run callbacks until a stop is requested or the middleware is shut down."""
    executor.context.on_shutdown(stop.make)
    # The events executor installs its own signal handlers when it is made.
    stop.take_signals()
    spin_once = executor.spin_once
    try:
        while not stop.made:
            spin_once(STEP)
    except ExternalShutdownException:
        pass

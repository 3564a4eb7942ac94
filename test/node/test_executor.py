# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop runs callbacks and ends when it is asked to, on either executor."""
import os
import signal
import sys
import threading

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from screw_kinematics.node.executor import make_executor, spin
from screw_kinematics.node.stop_request import StopRequest
from screw_kinematics.pipeline.settings import EXECUTORS
from std_msgs.msg import Empty


@pytest.fixture(params=EXECUTORS)
def executor(request, context):
    executor = make_executor(request.param, context)
    yield executor
    executor.shutdown()


@pytest.fixture
def node(context, executor):
    node = Node('looped', context=context)
    executor.add_node(node)
    yield node
    node.destroy_node()


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('busy', [False, True], ids=['idle', 'busy'])
def test_signals_end_the_loop(executor, node, number, busy):
    before = signal.getsignal(number)
    ticks = []

    def tick():
        ticks.append(None)
        if len(ticks) == 20:
            # From another thread, so that it meets the loop as well as a callback.
            threading.Thread(target=os.kill, args=(os.getpid(), number)).start()
            if not busy:
                timer.cancel()

    timer = node.create_timer(0.001, tick)
    with StopRequest() as stop:
        spin(executor, stop)
    assert len(ticks) >= 20
    assert signal.getsignal(number) == before


def test_a_signal_ends_the_loop_while_messages_never_cease(executor, node):
    publisher = node.create_publisher(Empty, 'echo', 100)
    echoes = []

    def echo(message):
        echoes.append(None)
        publisher.publish(message)
        if len(echoes) == 2000:
            threading.Thread(target=os.kill, args=(os.getpid(), signal.SIGTERM)).start()

    def begin():
        if not echoes:
            for _ in range(20):
                publisher.publish(Empty())

    node.create_subscription(Empty, 'echo', echo, 100)
    node.create_timer(0.05, begin)
    with StopRequest() as stop:
        spin(executor, stop)
    assert len(echoes) >= 2000


def test_a_shutdown_of_the_middleware_ends_the_loop(executor, node, context):
    ends = []

    def end():
        if not ends:    # once: from Kilted on, what belongs to a context dies with it
            ends.append(threading.Thread(target=context.try_shutdown))
            ends[0].start()

    node.create_timer(0.01, end)
    with StopRequest() as stop:
        spin(executor, stop)
    assert stop.made
    ends[0].join()


def test_errors_in_callbacks_are_told_and_do_not_end_the_loop(executor, node, capfd):
    turns = []
    with StopRequest() as stop:
        def fail():
            turns.append(None)
            if len(turns) == 3:
                stop.make()
            raise ZeroDivisionError('in a callback')

        node.create_timer(0.001, fail)
        spin(executor, stop)
    assert len(turns) >= 3
    assert 'passed over: in a callback' in capfd.readouterr().err


def test_without_an_events_executor_the_default_one_serves(context, monkeypatch):
    monkeypatch.setitem(sys.modules, 'rclpy.experimental', None)
    executor = make_executor('events', context)
    assert isinstance(executor, SingleThreadedExecutor)
    executor.shutdown()

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Work in the other thread: in which order, and what comes back."""
from threading import Event, Thread

import pytest
from screw_kinematics.errors import InvalidValueError
from screw_kinematics.node.worker import Background


@pytest.fixture
def background():
    background = Background()
    yield background
    background.close()


def test_urgent_work_is_done_first_and_results_come_only_when_collected(background, wait_until):
    begin, order, results, errors = Event(), [], [], []

    def work(name):
        def run():
            order.append(name)
            return name
        return run

    background.submit(begin.wait, results.append, errors.append)
    for name, urgent in ('slow 1', False), ('model 1', True), ('slow 2', False), ('model 2', True):
        background.submit(work(name), results.append, errors.append, urgent=urgent)
    assert background.pending == 5
    begin.set()
    wait_until(lambda: len(order) == 4)
    assert order == ['model 1', 'model 2', 'slow 1', 'slow 2'] and results == []
    wait_until(lambda: len(results) == 5, poll=background.collect)
    assert results == [True, *order] and errors == []
    assert background.pending == 0


@pytest.mark.parametrize('error, told', [
    (InvalidValueError('pitch is 7'), 'pitch is 7'), (KeyError('x'), "KeyError: 'x'")])
def test_errors_are_handed_over_and_the_thread_goes_on(background, wait_until, error, told):
    def fail():
        raise error

    results, errors = [], []
    background.submit(fail, results.append, errors.append)
    background.submit(lambda: 1, results.append, errors.append)
    wait_until(lambda: results == [1], poll=background.collect)
    assert [str(e) for e in errors] == [told]


def test_what_has_not_begun_at_the_end_is_dropped_and_the_thread_ends(wait_until, monkeypatch):
    threads, begin, done = [], Event(), []
    monkeypatch.setattr(Thread, 'start', lambda thread, start=Thread.start: (
        threads.append(thread), start(thread)))
    background = Background()
    background.submit(begin.wait, done.append, done.append)
    background.submit(lambda: done.append(1), done.append, done.append)
    background.close()
    begin.set()
    wait_until(lambda: not threads[0].is_alive())
    background.collect()
    assert done == [] and threads[0].daemon

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the messages: the newest counts, and none holds up the rest."""
from threading import Event, Thread

import pytest
from screw_kinematics.errors import InvalidValueError
from screw_kinematics.node.worker import THREADS, Worker


@pytest.fixture
def worker():
    worker = Worker()
    yield worker
    worker.close()


def test_results_come_only_when_collected(worker, wait_until):
    done, results = Event(), []
    worker.submit('arm', lambda: done.set() or 7, results.append, results.append)
    assert done.wait(60) and results == [] and worker.pending == 1
    wait_until(lambda: results == [7], poll=worker.collect)
    assert worker.pending == 0


def test_newer_work_does_not_wait_for_older_and_takes_its_place(worker, wait_until):
    end, results = Event(), []
    worker.submit('arm', lambda: end.wait() and 'old', results.append, results.append)
    worker.submit('hand', lambda: 'other', results.append, results.append)
    worker.submit('arm', lambda: 'new', results.append, results.append)
    wait_until(lambda: worker.pending == 0, poll=worker.collect)
    assert sorted(results) == ['new', 'other']
    end.set()
    wait_until(lambda: worker._running == 0, poll=worker.collect)
    assert sorted(results) == ['new', 'other']


def test_of_what_waits_the_newest_is_done_first_and_what_is_outdated_never(worker, wait_until):
    begin, order = Event(), []
    for k in range(THREADS):
        worker.submit(k, begin.wait, order.append, order.append)
    for key, what in ('a', 'outdated'), ('b', 'second'), ('a', 'first'):
        worker.submit(key, lambda what=what: order.append(what), lambda _: None, order.append)
    worker.submit('cancelled', lambda: order.append('cancelled'), order.append, order.append)
    worker.cancel('cancelled')
    assert order == [] and worker.pending == THREADS + 2
    begin.set()
    wait_until(lambda: worker.pending == 0, poll=worker.collect)
    assert {'first', 'second'} < set(map(str, order)) and not {'outdated', 'cancelled'} & set(
        map(str, order))


@pytest.mark.parametrize('error, told', [
    (InvalidValueError('pitch is 7'), 'pitch is 7'), (KeyError('x'), "KeyError: 'x'")])
def test_errors_are_handed_over_and_work_goes_on(worker, wait_until, error, told):
    def fail():
        raise error

    results, errors = [], []
    worker.submit('a', fail, results.append, errors.append)
    worker.submit('b', lambda: 1, results.append, errors.append)
    wait_until(lambda: worker.pending == 0, poll=worker.collect)
    assert results == [1] and [str(e) for e in errors] == [told]


def test_at_the_end_all_work_is_let_go_and_the_process_need_not_wait(wait_until, monkeypatch):
    threads, begin, done = [], Event(), []
    monkeypatch.setattr(Thread, 'start', lambda thread, start=Thread.start: (
        threads.append(thread), start(thread)))
    worker = Worker()
    worker.submit('a', begin.wait, done.append, done.append)
    worker.close()
    begin.set()
    wait_until(lambda: not threads[0].is_alive())
    worker.collect()
    assert done == [] and threads[0].daemon

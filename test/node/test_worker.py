# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Slow work beside the messages: the newest counts, and none holds up the rest."""
from functools import partial
from threading import Event, Thread

import pytest
from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import InvalidValueError
from screw_kinematics.node.worker import Worker
from screw_kinematics.programs.checkpoint import CHECKPOINT, checkpoint, NODES_BETWEEN


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
    wait_until(lambda: not worker._at_work, poll=worker.collect)
    assert sorted(results) == ['new', 'other']


def test_what_took_least_time_goes_first_and_all_others_wait(worker, wait_until):
    ended, at_work, results = Event(), [], []

    def long_work(k):
        while not ended.is_set():
            at_work.append(k)
            checkpoint()
        return 'long'

    for k in range(2):
        worker.submit(k, partial(long_work, k), results.append, results.append)
    # They take turns, which become longer: hardly ever does one work beside the other.
    wait_until(lambda: min(job.worked for job in worker._at_work) > 0.5)
    turns = sum(k != following for k, following in zip(at_work, at_work[1:]))
    assert 2 < turns < len(at_work) / 20
    worker.submit('short', lambda: checkpoint() or 'short', results.append, results.append)
    wait_until(lambda: results == ['short'], poll=worker.collect)
    ended.set()
    wait_until(lambda: worker.pending == 0, poll=worker.collect)
    assert results == ['short', 'long', 'long']


def test_work_that_stands_still_holds_up_none(worker, wait_until):
    end, results = Event(), []
    for k in range(6):
        worker.submit(k, end.wait, results.append, results.append)
    worker.submit('long', lambda: [checkpoint() for _ in range(1000)], results.append, int)
    wait_until(lambda: len(results) == 1, poll=worker.collect)
    end.set()
    wait_until(lambda: worker.pending == 0, poll=worker.collect)
    assert results[1:] == [True] * 6


@pytest.mark.parametrize('let_go', [
    lambda worker: worker.cancel('arm'), Worker.close,
    lambda worker: worker.submit('arm', lambda: 1, int, int)],
    ids=['cancelled', 'closed', 'replaced'])
def test_work_that_is_let_go_ends_at_its_next_checkpoint(worker, wait_until, let_go):
    looked_up = []

    def endless():
        while True:
            looked_up.append(1)
            checkpoint()

    worker.submit('arm', endless, looked_up.append, looked_up.append)
    wait_until(lambda: looked_up)
    let_go(worker)
    wait_until(lambda: not worker._at_work)
    worker.collect()
    assert set(looked_up) == {1} and not worker.pending


def test_a_long_trace_has_checkpoints():
    seen, chain = [], SerialChain([Joint(f'q{k}', 'revolute', (1, 2, k)) for k in range(40)])
    token = CHECKPOINT.set(lambda: seen.append(1))
    try:
        program = chain.compile(('accel',))
    finally:
        CHECKPOINT.reset(token)
    # Traced, placed and laid out.
    assert len(seen) > 2 * program.operations / NODES_BETWEEN


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

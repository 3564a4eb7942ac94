# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every kind of fault once, every message accounted for; and the checks do find errors."""
from collections import Counter
import json
import os
from pathlib import Path
import subprocess
import sys

import pytest

pytest.importorskip('pinocchio')
ROOT = Path(__file__).parents[2]


@pytest.fixture
def benchmark(monkeypatch):
    """Have the source tree's benchmark importable."""
    monkeypatch.syspath_prepend(str(ROOT))


def test_every_fault_once(ros_domain, tmp_path):
    figures = tmp_path / 'figures.json'
    ended = subprocess.run(
        [sys.executable, '-m', 'benchmark.soak', '--minutes', '0', '--rate', '100',
         '--calm', '1.7', '--seed', '3', '--json', str(figures)],
        cwd=ROOT, env=os.environ | {'PYTHONPATH': str(ROOT)}, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    result = json.loads(figures.read_text())
    assert result['passed'] and all(f['times'] == 1 for f in result['faults'].values())
    for account in result['accounts']:
        assert account['received'] == account['used'] + account['refused_total'] > 1000
    refused = Counter()
    for account in result['accounts']:
        refused.update(account['refused'])
        refused.update(account['of_topic'])
    assert {'stamp_not_increasing', 'joints_come_with_other_message'} <= refused.keys()


@pytest.mark.parametrize('output', ['puma/twist', 'rpr/accel'])
@pytest.mark.parametrize('harm', ['none', 'value', 'nan', 'stamp'])
def test_the_check_of_outputs_finds_what_is_wrong(benchmark, tmp_path, output, harm):
    import numpy as np
    from benchmark.soak.checks import Permitted, TopicCheck
    from benchmark.soak.robots import ROBOTS, SAMPLES, TICK_NS
    from benchmark.soak.shared import Progress
    from screw_kinematics.messages.stamped import TwistEncoder
    name, kind = output.split('/')
    number, robot = next((i, r) for i, r in enumerate(ROBOTS) if r.name == name)
    check = TopicCheck(number, robot, kind, Progress(tmp_path / 'progress', len(ROBOTS)))
    encode = TwistEncoder('base').encode
    begin = 1_700_000_000 * 1000 // SAMPLES * SAMPLES
    truth = robot.expected()[kind]
    for i in range(10):
        values, stamp = truth[i].copy(), (begin + i) * TICK_NS
        if i == 5 and harm == 'value':
            values[3:5] += 1e-8 if kind == 'twist' else 0.5 * np.abs(truth).max()
        elif i == 5 and harm == 'nan':
            values[4] = np.nan
        elif i == 5 and harm == 'stamp':
            stamp += 100 * TICK_NS
        check.take(encode(stamp, values))
    check.check(Permitted(settled_from=[begin] * len(ROBOTS)))
    tally = check.tally
    assert (tally.received, tally.exact + tally.estimated) == (10, 10)
    assert tally.not_finite == (harm == 'nan')
    if kind == 'twist':     # follows from one sample
        assert (tally.wrong, tally.too_far) == (harm != 'none', 0)
    else:
        assert (tally.wrong, tally.too_far) == (0, harm in ('value', 'stamp'))


@pytest.mark.parametrize('harm', ['none', 'value', 'instants'])
def test_outputs_of_a_batch_have_the_latency_that_the_surest_tell(benchmark, tmp_path, harm):
    import numpy as np
    from benchmark.soak.field.checks import Sent, TopicCheck
    from benchmark.soak.field.log import SentLog
    from benchmark.soak.field.robots import ROBOTS, SAMPLES
    from screw_kinematics.messages.stamped import TwistWithCovarianceEncoder
    number, robot = next((i, r) for i, r in enumerate(ROBOTS) if r.name == 'arrival')
    log, count, begin = SentLog(tmp_path / 'sent', len(ROBOTS)), 300, 10**18
    instants = 1.0 + 1e-3 * np.arange(count)
    stamps = begin + np.round(instants * 1e9).astype(np.int64)
    for name, column in (('stamp', stamps), ('instant', instants), ('sent', 0)):
        log.entries[number][name][:count] = column
    log.counts[number] = count
    sent = Sent(log, number)
    sent.update()
    check = TopicCheck(robot, 'twist_with_covariance', sent)
    begins = np.repeat([False, True, False], [60, 180, 60])     # most of them, and know little
    late = np.where(begins, 0.0, 0.75 * robot.latency)
    t = (instants - robot.delay - late) % (SAMPLES * 1e-3)
    by_tool = [robot.truth(t, model)['twist_with_covariance'] for model in (0, 1)]
    values = np.where(np.arange(count)[:, None] < 60, *by_tool)
    if harm == 'value':
        values[30, 4] += 1e-3
    elif harm == 'instants':
        values[20:30] = by_tool[0][120:130]
    encode = TwistWithCovarianceEncoder('base').encode
    for stamp, value, variance in zip(stamps.tolist(), values, np.where(begins, 1e-2, 1e-10)):
        check.take(encode(stamp - round(robot.delay * 1e9),
                          [*value, *(variance * np.eye(6)).ravel()]))
    check.check({0, 1}, 'a test')
    assert check.tally.judged == count
    assert check.tally.beyond == {'none': 0, 'value': 1, 'instants': 10}[harm]
    assert check.last_model == 1


@pytest.mark.parametrize('slip, period, proven, gap, found', [
    (0.0, 1e-3, True, 0.02, 'other, ticks are known'),
    (8e-4, 1e-3, True, 0.02, 'ticks miscounted in a pause'),
    (-8e-4, 1e-3, True, 3e-3, 'ticks miscounted without a pause'),
    (0.0, 1.05e-3, True, 3e-3, 'a wrong period'),
    (0.0, 2e-3, True, 3e-3, 'other, ticks are known'),
    (8e-4, 0.0, False, 0.02, 'a pause while stamps are believed'),
    (8e-4, 0.0, False, 3e-3, 'other, stamps are believed')])
def test_what_a_clock_took_readings_for_is_told_from_when_these_were(
        benchmark, slip, period, proven, gap, found):
    from benchmark.soak.field.losses import cause, Trace
    read = [0.0, 1e-3, 1e-3 + gap, 2e-3 + gap]
    traces = [Trace(t, 7.0 + t + slip * (t >= read[2]), period, proven) for t in read]
    assert cause(traces, 1e-3) == found


def test_a_busy_machine_loses_messages_and_holds_others_up_but_keeps_their_order(benchmark):
    import numpy as np
    from benchmark.soak.field.losses import received
    from benchmark.soak.field.robots import Message
    sent = [Message(1e-3 * k, 1e-3 * k, 1e-3 * k, 1e-3 * k) for k in range(5000)]
    for held in (False, True):
        found = received(sent, np.random.default_rng(1), held)
        assert 1000 < len(found) < 4900
        assert (np.diff([message.reading for message in found]) > 0.0).all()
        assert (np.diff([message.stamp for message in found]) > 0.0).all()
        late = np.array([message.stamp - message.reading for message in found])
        assert (late >= 0.0).all() and (late > 5e-3).any() == held


def test_contradictions_in_the_accounts_are_found(benchmark):
    from benchmark.soak.books import Account
    good = Account(10, 9, 7, 6, 2, Counter(a=2), Counter(b=1), Counter(c=1))
    assert good.contradictions() == []
    for change in ({'on_topic': 11}, {'used': 8}, {'refused': Counter(a=1)}):
        assert len(Account(**(vars(good) | change)).contradictions()) == 1


@pytest.mark.parametrize('seen, missing, wrong', [
    ([*range(10, 35, 5), *range(90, 105, 5)], 0, ''),
    ([*range(10, 25, 5), *range(90, 105, 5)], 2, ''),
    ([*range(10, 25, 5), *range(90, 105, 5)], 1, ''),      # the last one had not been counted
    ([*range(10, 25, 5), *range(90, 105, 5)], 3, '3 messages missing, but 2'),
    ([*range(10, 25, 5), *range(90, 105, 5)], -1, '-1 messages missing'),
    ([10, 20, *range(90, 105, 5)], 2, 'gaps elsewhere'),
    ([*range(10, 25, 5), 90, 100], 3, 'gaps elsewhere'),
    ([10, 15], 3, 'gaps elsewhere')])
def test_only_the_last_messages_of_a_killed_source_may_be_missing(
        benchmark, seen, missing, wrong):
    from benchmark.soak.tail import check_tail, Runs
    runs = Runs(step=5)
    for tick in seen:
        runs.take([tick])
    found = check_tail(runs.all, killed_at=35, step=5, missing=missing)
    assert found.startswith(wrong) and bool(found) == bool(wrong)

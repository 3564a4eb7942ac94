# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Streams at the ends of what there is: rates, numbers of joints, names, clocks."""
import numpy as np
import pytest
from screw_kinematics import Joint, models, SerialChain
from screw_kinematics.errors import Reason
from screw_kinematics.messages.joint_state import JointSample, JointStateDecoder
from screw_kinematics.pipeline.kinematics import Kinematics
from screw_kinematics.pipeline.robot_pipeline import RobotPipeline
from screw_kinematics.pipeline.robot_program import OneTip
from screw_kinematics.pipeline.settings import MotionSettings
from support import recordings as rec

START = 1_700_000_000_000_000_000
SCRIPTS = {
    'latin': 'joint_with_a_long_name', 'greek': 'άρθρωση', 'cyrillic': 'сустав', 'chinese': '关节',
    'arabic': 'مفصل', 'hindi': 'जोड़', 'emoji': '🦾', 'combining': 'e\u0301'}


def chain_of(names, seed=0):
    rng = np.random.default_rng(seed)
    return SerialChain([Joint(name, 'revolute', rng.normal(size=3), rng.normal(size=3) / 9)
                        for name in names])


def motion(n, t):
    """Return positions, velocities and accelerations of n joints that swing slowly, (..., n)."""
    k, t = np.arange(1, n + 1), np.asarray(t)[..., None]
    w = 0.4 + 0.3 * (k % 5)
    return 0.1 * np.sin(w * t + k), 0.1 * w * np.cos(w * t + k), -0.1 * w**2 * np.sin(w * t + k)


def errors(chain, rate, count, outputs=('accel',), start=START, stamp=lambda t: t, **settings):
    """Return relative errors of accelerations, the pipeline, and which samples gave some."""
    pipeline = RobotPipeline(chain.joint_names, MotionSettings(**settings))
    pipeline.activate(Kinematics(OneTip(chain.compile(outputs=outputs))))
    n, found, which = chain.dof, [], []
    size = np.abs(chain.state(*motion(n, np.linspace(0, 6, 20))).classical(2)).max()
    times = np.arange(count) / rate
    for k, (t, q, qd) in enumerate(zip(times.tolist(), *motion(n, times)[:2])):
        state = pipeline.take(JointSample(
            start + round(stamp(t) * 1e9), chain.joint_names, tuple(q.tolist()),
            tuple(qd.tolist())))
        if not isinstance(state, Reason):
            found.append(state.values[:6])
            which.append(k)
    account = pipeline.account
    assert account.received == count == account.used + account.refused.total()
    if not found:
        return np.empty(0), pipeline, which
    true = chain.state(*motion(n, times[which])).classical(2)
    return np.abs(np.array(found) - true).max(axis=-1) / size, pipeline, which


@pytest.mark.parametrize('n', [1, 2, 200])
def test_any_number_of_joints(n):
    found, _, _ = errors(chain_of([f'q{k}' for k in range(n)]), 250.0, 150)
    assert len(found) > 130 and found[-50:].max() < 1e-2


@pytest.mark.parametrize('rate, count', [(5.0, 100), (20.0, 200), (5000.0, 3000)])
def test_any_rate(rate, count):
    found, _, _ = errors(chain_of(['a', 'b', 'c']), rate, count)
    assert len(found) > count - 20 and found[count // 2:].max() < 0.05


def test_slower_than_the_longest_gap_is_told():
    found, pipeline, _ = errors(chain_of(['a', 'b']), 2.0, 30)
    assert len(found) == 0 and 'max_gap' in pipeline.doubts()[0]


@pytest.mark.parametrize('script', SCRIPTS)
def test_names_of_some_200_characters_in_any_script(script):
    """From the description to the bytes of a message, and joined by name."""
    names = [(f'{k}' + SCRIPTS[script] * 200)[:199] for k in range(3)]
    links = ''.join(f'<link name="{name}l"/>' for name in ['base', *names])
    joints = ''.join(
        f'<joint name="{name}" type="revolute"><parent link="{parent}l"/><child link="{name}l"/>'
        '<origin xyz="0.3 0 0.1"/><axis xyz="0 1 0"/></joint>'
        for parent, name in zip(['base', *names], names))
    chain = models.load_urdf(f'<robot name="{names[0]}">{links}{joints}</robot>')
    assert chain.joint_names == tuple(names)
    q, qd, _ = motion(3, 0.7)
    data = rec.joint_state(START, names[::-1], q[::-1], qd[::-1])
    sample = JointStateDecoder(lambda _: pytest.fail('plain CDR')).decode(data)
    pipeline = RobotPipeline(chain.joint_names, MotionSettings(velocity_source='measured'))
    pipeline.activate(Kinematics(OneTip(chain.compile(outputs=('twist',)))))
    state = pipeline.take(sample)
    np.testing.assert_allclose(state.values, chain.state(q, qd).classical(1), atol=1e-12)


@pytest.mark.parametrize('delay', [0.0, 0.02])
@pytest.mark.parametrize('rate', [100.0, 1000.0])
def test_a_second_that_comes_twice(rate, delay):
    """As the clock of a system that repeats the second of a leap; the joints go on."""
    chain = chain_of(['a', 'b', 'c'])
    leap = int(2 * rate)
    found, pipeline, which = errors(
        chain, rate, int(4 * rate), stamp=lambda t: t if t < leap / rate else t - 1.0)
    assert found[10:].max() < 0.5       # nothing but a few times the usual error
    assert sum(k > leap + rate for k in which) > 0.9 * rate
    assert found[np.array(which) > leap + rate].max() < 0.05
    assert pipeline.account.refused.total() < 30


@pytest.mark.parametrize('start', [0, -10**18])
def test_clocks_at_and_before_1970(start):
    """Just after 1970 is a time like others; what lies before is refused where it comes in."""
    found, pipeline, _ = errors(chain_of(['a', 'b']), 250.0, 300, start=start)
    assert len(found) > 280 and found[-50:].max() < 1e-2


@pytest.mark.parametrize('start', [-5 * 10**9, -10**9 // 2])
def test_recorded_stamps_before_1970_are_counted(tmp_path, capsys, start):
    from screw_kinematics.tools.bag import main as bag
    rows = [(topic, kind, received, rec.joint_state(
        start + k * 5_000_000, rec.PUMA.joint_names, np.full(6, 0.1), np.zeros(6)))
        for k, (topic, kind, received, _) in enumerate(rec.samples(400))]
    path = rec.write_bag(tmp_path / 'old', rows)
    bag.main([str(path), '--robot', str(rec.ROBOTS / 'puma560.yaml'), '--name', 'puma',
              '--output', str(tmp_path / 'out')])
    shown = capsys.readouterr()
    refused = min(400, -start // 5_000_000)
    assert f'{refused} stamp_negative' in shown.out + shown.err

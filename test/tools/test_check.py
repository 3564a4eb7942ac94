# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Each fault that is put in is found, and a sound recording has none."""
import itertools
from pathlib import Path
import re

import numpy as np
import pytest

from screw_kinematics.tools.check import main as check
from support import recordings as rec

ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
PUMA = str(ROBOTS / 'puma560.yaml')
NAMES = rec.PUMA.joint_names


def motion(t, rest=3.0):
    """Return positions and velocities: a rest, then the motion."""
    q, qd = rec.MOTION.derivatives(np.maximum(t - rest, 0.0), 1)
    return (np.round(q / rec.QUANTUM) * rec.QUANTUM,
            np.where((np.asarray(t) < rest)[..., None], 0.0, qd))


def messages(count=600, rate=200.0, late=300_000, change=None, rest=0.5):
    """Yield messages of a bag; ``change`` may alter stamp, names, position, velocity."""
    times = np.arange(count) / rate
    for k, (t, q, qd) in enumerate(zip(times.tolist(), *motion(times, rest))):
        stamp = rec.START + round(t * 1e9)
        sample = [stamp, list(NAMES), q, qd]
        if change is not None:
            change(k, sample)
        yield '/joint_states', rec.JOINT_STATE, stamp + late, rec.joint_state(*sample)


def run(tmp_path, capsys, arguments=(), **options):
    """Check a bag; return exit code and output."""
    path = rec.write_bag(tmp_path / 'run', messages(**options))
    code = check.main(['bag', str(path), '--robot', PUMA, *arguments])
    return code, capsys.readouterr().out


def test_sound_joint_states(tmp_path, capsys):
    code, out = run(tmp_path, capsys, count=1600, rest=3.0)
    assert code == 0 and 'problem' not in out
    assert '/joint_states: 200.0 Hz' in out and '0.30 ms old' in out
    assert f'smallest step of a position {rec.QUANTUM:.2g}' in out
    assert 'recommended: estimator.delay: ' in out
    # Later is better: the errors in motion fall with the delay.
    errors = [float(x) for x in re.findall(r'; ([\d.e-]+) in motion', out)]
    assert len(errors) == 5 and errors[0] > 2 * errors[2]


def zero_velocity(k, sample):
    sample[3] = np.zeros(6)


def no_velocity(k, sample):
    sample[3] = ()


def late_velocity(k, sample):
    sample[3] = motion(k / 200.0 - 0.03, 0.5)[1]


def missing_joint(k, sample):
    for i in (1, 2, 3):
        sample[i] = sample[i][:5]


def zero_stamps(k, sample):
    sample[0] = 0


def some_zero_stamps(k, sample):
    if k % 50 == 9:
        sample[0] = 0


def repeated_stamps(k, sample):
    sample[0] -= (k % 2) * 5_000_000


def played_in_a_loop(k, sample):
    sample[0] -= k // 200 * 1_000_000_000


def pause(k, sample):
    sample[0] += (k > 300) * 1_500_000_000


def not_finite(k, sample):
    sample[2] = np.where(k % 100 == 7, np.nan, sample[2])


def wrong_length(k, sample):
    if k % 200 == 9:
        sample[2] = sample[2][:4]


@pytest.mark.parametrize('change, code, message', [
    (zero_velocity, 0, r'velocity of q1, .* is always zero'),
    (no_velocity, 0, r'velocity is not measured'),
    (late_velocity, 0, r'velocity of q1 lags its position by (29|30|31) ms'),
    (missing_joint, 1, r'nobody publishes q6'),
    (zero_stamps, 0, r'stamps are zero; 200.0 messages a second'),
    (some_zero_stamps, 0, r'(?s)12 stamps are zero(?!.*stamps go back|.*pauses)'),
    (repeated_stamps, 0, r'300 stamps repeat the one before'),
    (played_in_a_loop, 1, r'stamps go back 2 times, by up to 1.00 s: a recording that was played'),
    (pause, 0, r'1 pauses longer than 0.25 s, the longest 1.5\d s'),
    (not_finite, 1, r'6 messages have positions that are not finite'),
    (wrong_length, 1, r'3 messages have another number of positions than of names \(6\)'),
], ids=lambda x: getattr(x, '__name__', None))
def test_faults_are_found(tmp_path, capsys, change, code, message):
    found, out = run(tmp_path, capsys, change=change)
    assert re.search(message, out), out
    assert found == code


TOLD = {}


def told_of(change, tmp_path, capsys):
    """Check a bag with a fault of the readings, each once; return exit code and output."""
    if change not in TOLD:
        TOLD[change] = run(tmp_path, capsys, change=change, count=1200)
    return TOLD[change]


def sent_twice(k, sample):
    if k in (300, 400, 500):
        sample[2] = motion((k - 1) / 200.0, 0.5)[0]


def held(k, sample):
    sample[2] = motion((k - k % 4) / 200.0, 0.5)[0]


def stands_still(k, sample):
    if 400 <= k < 412:
        sample[2] = motion(399 / 200.0, 0.5)[0]


def in_degrees(k, sample):
    sample[2], sample[3] = np.degrees(sample[2]) + 90, np.degrees(sample[3])


def in_ticks(k, sample):
    sample[2] = np.rint(sample[2] * 65536 / (2 * np.pi)) + 5000


def in_coarse_ticks(k, sample):
    sample[2] = np.rint(motion(k / 200.0, 5.0)[0] * 65536 / (2 * np.pi))
    sample[3] = ()


def wrapped(k, sample):
    sample[2][0] += np.pi - motion(2.0, 0.5)[0][0]
    sample[2] = (sample[2] + np.pi) % (2 * np.pi) - np.pi


def noisy(k, sample):
    sample[2] = sample[2] + np.random.default_rng(k).normal(0, 3e-4, 6)
    sample[3] = ()


@pytest.mark.parametrize('change, code, message', [
    (sent_twice, 0, r'remark .*: 3 positions repeat the one before while the robot moves\n'
                    r' +-> .*let the driver send each once'),
    (held, 0, r'remark .*: positions change 50.0 times a second only, though messages come 200.0 '
              r'times.*\n +-> readings are held: let the driver send each once'),
    (stands_still, 0, r'remark .*: 12 positions repeat .*; the longest for 60 ms'),
    (in_degrees, 1, r'problem .*: q1 \(revolute\) reaches [\d.]+ rad, [\d.]+ turns\n'
                    r' +-> are these degrees\?: positions must be in rad'),
    (in_ticks, 1, r'problem .*: q1 \(revolute\) reaches .*\n +-> these are whole numbers'),
    (in_coarse_ticks, 1, r'problem .*: q1 \(revolute\) reaches .*\n +-> these are whole numbers'),
    (wrapped, 1, r'problem .*: q1 \(revolute\) jumps by a whole turn, 6.283, \d+ times\n'
                 r".* 'continuous'"),
    (noisy, 1, r'problem .*: with estimator.delay: 0 accelerations are wrong by \d+ % of the '
               r'signal\n +-> set estimator.delay: 0.0[1-5]'),
], ids=lambda x: getattr(x, '__name__', None))
def test_faults_of_the_readings(tmp_path, capsys, change, code, message):
    found, out = told_of(change, tmp_path, capsys)
    assert re.search(message, out), out
    assert found == (code if change is not held else found)
    assert 'keep estimator.delay: 0' not in out or change is not noisy


def other_publisher(says, every=4, names=NAMES):
    """Yield messages, and among them those of a second publisher."""
    for k, message in enumerate(messages(count=1600)):
        yield message
        if k % every == 0:
            stamp = message[2] - 300_000 + 2_000_000
            yield '/joint_states', rec.JOINT_STATE, stamp + 400_000, rec.joint_state(
                stamp, names, says(k / 200.0)[:len(names)], ())


@pytest.mark.parametrize('says, every, words', [
    (lambda t: np.zeros(6), 4, ['one 200 messages a second of a motion',
                                'one 50 messages a second of zeros (a forgotten joint_state_']),
    (lambda t: np.full(6, 0.5), 1, ['one 200 messages a second that never change (q1 0.5']),
    (lambda t: motion(t - 0.4, 0.5)[0] - 0.3, 2,
     ['one 200 messages a second of a motion', 'one 100 messages a second of a motion'])])
def test_two_publishers_that_disagree_are_told_apart(tmp_path, capsys, says, every, words):
    path = rec.write_bag(tmp_path / 'run', other_publisher(says, every))
    code = check.main(['bag', str(path), '--robot', PUMA])
    line, = [line for line in capsys.readouterr().out.splitlines()
             if 'two publishers disagree on joints' in line]
    assert code == 1 and all(word in line for word in words), line


@pytest.mark.parametrize('says, code, words', [
    (lambda t: np.zeros(7), 1, 'two publishers disagree on joints q1, q2, q3, q4, q5, q6: '
                               '6 joints in 200 messages a second of a motion, 7 joints in 50 '
                               'messages a second of zeros'),
    (lambda t: np.append(motion(t, 0.5)[0], 0), 0, 'two publishers bring joints q1, q2')])
def test_joints_that_come_in_messages_of_other_names_too(tmp_path, capsys, says, code, words):
    path = rec.write_bag(tmp_path / 'run', other_publisher(says, names=[*NAMES, 'finger']))
    found = check.main(['bag', str(path), '--robot', PUMA])
    out = capsys.readouterr().out
    assert words in out and ('two publishers disagree' in out) == bool(code)
    assert found == 1 or not code


def velocity_is_position(k, sample):
    sample[3] = sample[2]


def velocity_is_commanded(k, sample):
    sample[3] = np.full(6, 1.5)


@pytest.mark.parametrize('change, words', [
    (velocity_is_position, 'the velocity field of joints q1, q2, q3, q4, q5, q6 holds the pos'),
    (velocity_is_commanded, 'the velocity field of joints q1 (1.5), q2 (1.5), q3 (1.5), q4 (1.5), '
                            'q5 (1.5), q6 (1.5) never changes while they move')])
def test_a_velocity_field_that_holds_something_else_is_named(tmp_path, capsys, change, words):
    code, out = run(tmp_path, capsys, change=change, count=1000)
    assert code == 1 and words in out


def test_a_glitch_is_no_second_publisher(tmp_path, capsys):
    def glitch(k, sample):
        if k in (300, 500):
            sample[2] = sample[2] + 0.1

    _, out = run(tmp_path, capsys, change=glitch)
    assert 'two publishers' not in out


@pytest.mark.parametrize('sigma', [0.01, 0.05, 0.3])
def test_a_noisy_source_is_no_second_publisher(tmp_path, capsys, sigma):
    rng = np.random.default_rng(1)

    def noise(k, sample):
        sample[2] = sample[2] + rng.normal(0, sigma, 6)

    _, out = run(tmp_path, capsys, change=noise, count=1200)
    assert 'two publishers' not in out
    assert re.search('remark .* jump there and back from sample to sample, of one noisy', out), out


@pytest.mark.parametrize('change', [sent_twice, held, stands_still, noisy])
def test_one_delay_is_advised(tmp_path, capsys, change):
    _, out = told_of(change, tmp_path, capsys)
    advised = re.findall(r'(?:set|such as|recommended:) estimator\.delay: ([\d.]+)', out)
    assert len(advised) == 1 or 'no delay helps' in out and not advised, out
    assert set(re.findall(r'-> .*estimator\.delay: ([\d.]+)', out)) <= {*advised, '0'}


def test_ordinary_encoders_are_not_said_to_repeat(tmp_path, capsys):
    """A coarse encoder often reads the same twice, as it must."""
    def coarse(k, sample):
        sample[2] = np.round(sample[2] / 2e-3) * 2e-3
    _, out = run(tmp_path, capsys, change=coarse, count=1200)
    assert 'repeat the one before' not in out and 'times a second only' not in out


@pytest.mark.parametrize('late, code, message', [
    (-50_000_000, 1, r'50.0 ms in the future'), (400_000_000, 0, r'400 ms old')])
def test_clocks(tmp_path, capsys, late, code, message):
    found, out = run(tmp_path, capsys, late=late)
    assert re.search(message, out) and found == code


def test_what_is_said_of_a_delay_names_the_joints(tmp_path, capsys):
    """Of an arm and its wrist, say, which come in messages of their own."""
    parts = [rec.samples(count, rate=rate, joints=joints) for count, rate, joints in (
        (400, 200.0, slice(0, 4)), (200, 100.0, slice(4, 6)))]
    path = rec.write_bag(tmp_path / 'run', sorted(
        itertools.chain(*parts), key=lambda message: message[2]))
    assert check.main(['bag', str(path), '--robot', PUMA]) == 0
    advice = [line for line in capsys.readouterr().out.splitlines() if 'recommended' in line]
    for line, joints in zip(advice, ('q1, q2, q3, ...', 'q5, q6'), strict=True):
        assert f'/joint_states ({joints}): recommended' in line


def test_other_topic(tmp_path, capsys):
    code, out = run(tmp_path, capsys, ['--topic', 'joints'], count=50)
    assert code == 1 and '/joints: no joint state came' in out


@pytest.mark.parametrize('robot', sorted(path.stem for path in ROBOTS.glob('*.yaml')))
def test_shipped_models_are_sound(robot, capsys):
    assert check.main(['model', str(ROBOTS / f'{robot}.yaml')]) == 0
    assert 'measured joints, which must be published' in capsys.readouterr().out


def test_freedom_of_the_planar_arm(capsys):
    assert check.main(['model', str(ROBOTS / 'rpr.yaml')]) == 0
    assert 'tool moves in 3 of 6 directions' in capsys.readouterr().out


def test_operations_of_a_parallel_robot_are_those_of_its_newton_steps(capsys):
    assert check.main(['model', str(ROBOTS / 'stewart_6ups.yaml')]) == 0
    (count,) = re.findall(r'take (\d+) operations, two Newton steps included',
                          capsys.readouterr().out)
    assert int(count) > 5000


def test_mimic_sources_are_named(tmp_path, capsys):
    (tmp_path / 'arm.urdf').write_text("""<robot name="arm">
      <link name="a"/><link name="b"/><link name="c"/>
      <joint name="j1" type="prismatic"><parent link="a"/><child link="b"/>
        <axis xyz="1 0 0"/><limit effort="1" velocity="1" lower="0" upper="1"/>
        <mimic joint="j2" multiplier="-2" offset="0.5"/></joint>
      <joint name="j2" type="continuous"><parent link="a"/><child link="c"/></joint>
    </robot>""")
    assert check.main(['model', str(tmp_path / 'arm.urdf'), '--tip', 'b']) == 0
    out = capsys.readouterr().out
    assert "'j1' follows 'j2', a joint outside the chain: q = -2 q + 0.5" in out


@pytest.mark.parametrize('arguments', [['no_such.yaml'], [PUMA, '--tip', 'hand']])
def test_models_that_cannot_be_used_are_a_problem(arguments, capsys):
    assert check.main(['model', *arguments]) == 1
    assert capsys.readouterr().out.startswith('problem ')


def test_what_cannot_be_checked(tmp_path, capsys):
    assert check.main(['bag', str(tmp_path)]) == 2
    assert check.main(['system', '--seconds', '0']) == 2
    assert 'no bag there' in capsys.readouterr().err


def test_a_table_is_checked_as_a_bag_is(tmp_path, capsys):
    rows = ['stamp,' + ','.join(NAMES)]
    for k in range(600):
        q, _ = motion(k / 200.0, 0.5)
        rows.append(f'{k / 200.0},' + ','.join(map(str, q)))
    (tmp_path / 'x.csv').write_text('\n'.join(rows))
    assert check.main(['bag', str(tmp_path / 'x.csv'), '--robot', PUMA]) == 0
    out = capsys.readouterr().out
    assert '200.0 Hz' in out and 'recommended: estimator.delay' in out
    assert check.main(['bag', str(tmp_path / 'x.csv'), '--robot', PUMA,
                       '--units', 'deg']) == 0

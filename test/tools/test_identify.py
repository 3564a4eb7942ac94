# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A payload is found from motion and wrenches, as well as is said, and the node takes it."""
from functools import cache

import numpy as np
import pytest

pytest.importorskip('mujoco')

from screw_kinematics.pipeline.parameter_file import read_robots    # noqa: E402
from screw_kinematics.pipeline.payload import is_inertia    # noqa: E402
from screw_kinematics.recordings.payload_fit import nearest_body    # noqa: E402
from screw_kinematics.tools.bag import main as bag    # noqa: E402
from screw_kinematics.tools.identify import main as identify    # noqa: E402
from support import loaded_arm as arm, loaded_recording, recordings as rec    # noqa: E402


@pytest.fixture
def robot(tmp_path):
    file = tmp_path / 'arm.urdf'
    file.write_text(arm.urdf())
    return str(file)


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    """Return what writes a recording, each once."""
    return cache(lambda **options: loaded_recording.write(
        tmp_path_factory.mktemp('written') / 'run', **options))


def run(path, robot, capsys, *more, code=0):
    """Run the tool; return what it printed."""
    found = identify.main(['payload', str(path), '--robot', robot, '--wrench', '/ft',
                           '--name', 'arm', *more])
    out, err = capsys.readouterr()
    assert found == code, out + err
    return out if code < 2 else err


def settings(text, robot, tmp_path, **more):
    """Return the settings of the node with the parameters that were printed."""
    given = {'description': robot, 'tip_frame': 'tool0', 'outputs': '[twist, compensated_wrench]',
             **more}
    lines = text.splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if line.strip() == 'arm:') + 1
    lines[at:at] = [f'      {key}: {value}\n' for key, value in given.items()]
    lines[at - 1:at - 1] = ['    robots: [arm]\n']
    file = tmp_path / 'parameters.yaml'
    file.write_text(''.join(lines))
    return file, read_robots(file)[0]


@pytest.mark.parametrize('options', [
    {}, {'sign': -1.0}, {'speed': 1.0}, {'contact': lambda t: (t > 3) & (t < 3.6)}])
def test_payload_is_found_and_compensated(options, robot, written, tmp_path, capsys):
    path = written(**options)
    text = run(path, robot, capsys)
    file, found = settings(text, robot, tmp_path)
    assert found.wrench_by == ('load' if options.get('sign', 1) > 0 else 'sensor')
    assert found.wrench_frame == arm.FRAME and found.wrench_topic == '/ft'
    assert found.payload.mass == pytest.approx(arm.BODY.mass, rel=0.01)
    np.testing.assert_allclose(found.payload.center, arm.BODY.center, atol=0.002)
    np.testing.assert_allclose(found.payload.inertia, arm.BODY.inertia, atol=5e-4)
    np.testing.assert_allclose(found.wrench_bias, arm.BIAS, atol=0.05)
    assert ('left out, as if there was contact' in text) == ('contact' in options)
    # With these parameters another motion has a tenth left of what weight alone leaves.
    other = written(begin=20.0, seed=1, sign=options.get('sign', 1.0))
    assert bag.main([str(other), '--params-file', str(file), '--output',
                     str(tmp_path / 'out')]) == 0, capsys.readouterr()
    messages = rec.read_bag(tmp_path / 'out')['/arm/compensated_wrench']
    assert len(messages) > 3900
    left = np.array([[m.wrench.force.x, m.wrench.force.y, m.wrench.force.z]
                     for _, m in messages[100:-100]])
    assert {m.header.frame_id for _, m in messages} == {arm.FRAME}
    assert np.sqrt((left**2).sum(axis=1).mean()) < 0.1 * 7     # test_compensation has the 7 N
    assert (rec.stamp_of(messages[50][1]) - rec.START) % 2_000_000 == 0


def test_it_is_drawn(robot, written, tmp_path, capsys):
    pytest.importorskip('matplotlib')
    path = written()
    run(path, robot, capsys, '--plot', str(tmp_path / 'payload.png'))
    assert (tmp_path / 'payload.png').read_bytes().startswith(b'\x89PNG')
    assert 'payload.txt' in run(path, robot, capsys, '--plot', 'payload.txt', code=2)


def test_standard_deviations_are_right(robot, tmp_path, capsys):
    """Of 12 recordings times 16 parameters: errors are of the size that is said."""
    from screw_kinematics.recordings.link_motion import LinkMotion
    from screw_kinematics.recordings.payload_fit import fit_payload
    from screw_kinematics import models
    chain = models.load_urdf(arm.urdf(), tip_frame=arm.FRAME)
    t, at = np.arange(0, 8, 0.004), np.arange(0.1, 7.9, 0.0025)
    state = chain.state(*arm.motion(t))
    twist, accel = state.classical(1), state.classical(2)
    link = LinkMotion(np.rint(t * 1e9).astype(np.int64), state.pose[:, :3, :3],
                      state.pose[:, :3, 3], twist[:, 3:], accel[:, 3:], twist[:, :3], accel[:, :3])
    shown = arm.wrenches(at)
    truth = np.array([arm.BODY.mass, *arm.BODY.center, *arm.BODY.inertia, *arm.BIAS])
    scores = []
    for seed in range(12):
        noise = arm.NOISE * np.random.default_rng(seed).normal(size=shown.shape)
        fit = fit_payload(link, np.rint(at * 1e9).astype(np.int64), shown + noise,
                          (0, 0, -9.80665))
        found = np.array([fit.payload.mass, *fit.payload.center, *fit.payload.inertia, *fit.bias])
        scores.append((found - truth) / fit.deviations)
    assert 0.75 < np.sqrt(np.mean(np.square(scores))) < 1.2
    assert np.abs(scores).max() < 4.5


def test_clocks_that_are_apart_are_told_and_made_up_for(robot, written, tmp_path, capsys):
    path = written(offset=0.012)
    text = run(path, robot, capsys)
    assert 'remark: /ft: stamps are 12.0' in text and 'early' in text
    _, found = settings(text, robot, tmp_path)
    assert found.motion.stamp_offset == pytest.approx(-0.012, abs=2e-4)
    assert found.payload.mass == pytest.approx(arm.BODY.mass, rel=0.01)
    np.testing.assert_allclose(found.payload.center, arm.BODY.center, atol=0.002)


def test_what_motion_would_tell_more_is_said(robot, written, tmp_path, capsys):
    text = run(written(speed=0.1, seconds=4), robot, capsys)
    assert 'moment of inertia about x is known to' in text
    assert 'turn to and fro about the x axis of the sensor, faster' in text
    assert 'tells nothing of the inertia' in text and 'stamps are' not in text
    _, found = settings(text, robot, tmp_path)
    assert found.payload.inertia == (0.0,) * 6
    assert found.payload.mass == pytest.approx(arm.BODY.mass, rel=0.05)
    # Between the two the inertia found may be none; what is printed is that of a body.
    text = run(written(speed=0.5), robot, capsys)
    _, found = settings(text, robot, tmp_path)
    assert is_inertia(found.payload.inertia) and any(found.payload.inertia)


@pytest.mark.parametrize('options, more, message', [
    ({'frame': 'hand'}, [], r"got 'hand'.*as the link of /ft; name the sensor's link by --frame"),
    ({}, ['--frame', 'nowhere'], r"got 'nowhere'.*allowed: a link"),
    ({}, ['--tip', 'nowhere'], r"got 'nowhere'.*allowed: a link"),
    ({'shift': 100.0}, [], r'0 of 3200 wrenches were measured while joint states came; allowed: '
     r'at least 100 \(do they overlap in time\?\)'),
    ({'still': True}, [], 'nothing moves while wrenches are measured'),
    ({}, ['--wrench', '/nothing'], r'no wrenches on /nothing; topics of type .*: /ft'),
    ({}, ['--gravity', '0', '0', 'nan'], "parameter 'gravity' is .*three finite numbers")])
def test_wrong_input_is_one_line(options, more, message, robot, written, tmp_path, capsys):
    path = written(**options)
    error = run(path, robot, capsys, *more, code=2)
    assert error.count('\n') == 1
    with pytest.raises(AssertionError, match=message):
        raise AssertionError(error)


def test_the_nearest_body():
    for six in np.random.default_rng(0).normal(size=(200, 6)):
        body = nearest_body(six.tolist())
        assert is_inertia(body)
        np.testing.assert_allclose(nearest_body(body), body, atol=1e-7)

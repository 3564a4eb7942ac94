# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Clocks that are apart are found to be so, with an interval that holds what it promises."""
from dataclasses import replace
from functools import cache
import re

import numpy as np
import pytest

from screw_kinematics.errors import ToolError
from screw_kinematics.recordings.clock_offset import Channels, find_offset
from screw_kinematics.recordings.link_motion import LinkMotion
from screw_kinematics.recordings.motion_streams import channels, read_stream, Stream
from screw_kinematics.recordings.recording import Recording
from screw_kinematics.screws.rotations import rotation_rpy, rotation_vector
from screw_kinematics.tools.check import main as check
from screw_kinematics.tools.check.offset_picture import draw_offset
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')
IMU, WRENCH = 'sensor_msgs/msg/Imu', 'geometry_msgs/msg/WrenchStamped'
POSE, ODOMETRY = 'geometry_msgs/msg/PoseStamped', 'nav_msgs/msg/Odometry'
TURN, ARM, BIAS = rotation_rpy(0.3, -0.5, 1.2), np.array([0.03, -0.05, 0.08]), 0.02


def link(t):
    """Return the exact motion of the PUMA's tip at times since the start [s]."""
    state = rec.PUMA.state(*rec.MOTION.derivatives(t, 2))
    twist, accel = state.classical(1), state.classical(2)
    return LinkMotion(np.rint(t * 1e9).astype(np.int64) + rec.START, state.pose[:, :3, :3],
                      state.pose[:, :3, 3], twist[:, 3:], accel[:, 3:], twist[:, :3],
                      accel[:, :3])


def measured(kind, t, offset, rng, noise=1.0):
    """Return what a sensor measures that is mounted anyhow, with stamps that are off."""
    at = link(t + offset)
    omega, alpha = at.in_link(at.angular_velocity), at.in_link(at.angular_acceleration)
    force = at.in_link(at.acceleration + [0, 0, 9.81]) + np.cross(alpha, ARM) + np.cross(
        omega, np.cross(omega, ARM))
    velocity = at.in_link(at.velocity)
    values = {IMU: [omega @ TURN.T + BIAS, force @ TURN.T], WRENCH: [1.7 * force @ TURN.T + 2.0],
              POSE: [at.position @ TURN.T + np.einsum('nij,j->ni', at.rotation, ARM) @ TURN.T + 1],
              ODOMETRY: [omega, velocity]}[kind]
    scales = {IMU: (0.01, 0.1), WRENCH: (0.3,), POSE: (5e-4,), ODOMETRY: (0.02, 0.02)}[kind]
    rows = [v + noise * s * rng.normal(size=v.shape) for v, s in zip(values, scales)]
    return Stream(kind, np.rint(t * 1e9).astype(np.int64) + rec.START,
                  np.concatenate(rows, axis=1))


@pytest.fixture(scope='module')
def joints():
    return link(np.arange(0, 6, 0.004))


def found(joints, seed, kind=IMU, noise=1.0):
    """Return the offset put in and the one found."""
    rng = np.random.default_rng(seed)
    offset = rng.uniform(-0.02, 0.02)
    stream = measured(kind, np.arange(0.003, 6, 0.01), offset, rng, noise)
    return offset, find_offset(joints.stamps, stream.stamps, channels(stream, joints))


@pytest.mark.parametrize('kind', [IMU, WRENCH, POSE, ODOMETRY])
@pytest.mark.parametrize('seed', range(3))
def test_offsets_are_found(kind, seed, joints):
    offset, clock = found(joints, seed, kind)
    assert abs(clock.offset - offset) < 4 * clock.deviation
    assert clock.deviation < {IMU: 2e-4, WRENCH: 2e-3, POSE: 5e-4, ODOMETRY: 5e-4}[kind]
    # Where the sensor is good, or the motion large, it is found exactly.
    offset, clock = found(joints, seed, kind, noise=0.05)
    assert abs(clock.offset - offset) < 2e-4 and min(clock.shares) > 0.98


def test_the_interval_holds_what_it_promises(joints):
    """In 120 seeded cases: 95 %, but for the chance of 120 draws (two and a half sigma: 5 %)."""
    hits = 0
    for seed in range(120):
        offset, clock = found(joints, seed, ODOMETRY)
        low, high = clock.interval
        hits += low < offset < high
    assert 0.90 <= hits / 120 <= 0.995


def test_motion_that_hardly_tells_has_a_wide_interval():
    """A second of motion and a bad sensor: no minimum is far below the others."""
    joints, hits, tries = link(np.arange(0, 1.5, 0.004)), 0, 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        offset = rng.uniform(-0.02, 0.02)
        stream = measured(WRENCH, np.arange(0.003, 1.5, 0.01), offset, rng)
        try:
            clock = find_offset(joints.stamps, stream.stamps, channels(stream, joints))
        except ToolError:       # no offset at all
            continue
        tries += 1
        hits += clock.interval[0] < offset < clock.interval[1]
    assert tries > 20 and hits / tries > 0.9


def test_noise_that_is_coloured_widens_the_interval():
    rng = np.random.default_rng(1)
    stamps = np.arange(0, 60 * 10**9, 5 * 10**6)
    t = stamps * 1e-9
    features = np.sin(t * 3)[:, None] + 0.5 * np.sin(t * 7.1)[:, None]
    white = rng.normal(size=(len(t), 1))
    smooth = np.convolve(white[:, 0], np.ones(20) / np.sqrt(20), 'same')[:, None]
    clocks = [find_offset(stamps, stamps, [Channels(features + 0.2 * noise, features)])
              for noise in (white, smooth)]
    assert clocks[1].deviation > 2.5 * clocks[0].deviation


def test_clocks_that_run_apart():
    stamps = np.arange(0, 60 * 10**9, 5 * 10**6)

    def signal(t):
        return np.stack([np.sin(3 * t), np.cos(4.3 * t)], axis=1)
    t = stamps * 1e-9
    values = signal(t + 0.012 + 2e-4 * (t - 30))
    clock = find_offset(stamps, stamps, [Channels(values, signal(t))])
    assert clock.offset == pytest.approx(0.012, abs=1e-5)
    assert clock.drift == pytest.approx(2e-4, abs=1e-6)


def test_what_tells_nothing_is_said(joints):
    stream = measured(IMU, np.arange(0.003, 6, 0.01), 0.0, np.random.default_rng(0))
    with pytest.raises(ToolError, match='do they overlap in time'):
        find_offset(joints.stamps, stream.stamps + 10**12, channels(stream, joints))
    still = joints._replace(**{name: np.repeat(getattr(joints, name)[:1], len(joints.stamps), 0)
                               for name in joints._fields[1:]})
    with pytest.raises(ToolError, match='nothing moves'):
        find_offset(joints.stamps, stream.stamps, channels(stream, still))
    stuck = [replace(group, values=np.ones_like(group.values))
             for group in channels(stream, joints)]
    with pytest.raises(ToolError, match='never changes.*is the sensor connected'):
        find_offset(joints.stamps, stream.stamps, stuck)


def test_what_never_turns_tells_by_how_it_slides(joints, tmp_path):
    """As of a gantry, whose simulated gyroscope is always zero."""
    stream = measured(ODOMETRY, np.arange(0.003, 6, 0.01), 0.01, np.random.default_rng(0))
    turning, sliding = channels(stream, joints)
    still = Channels(np.zeros_like(turning.values), np.zeros_like(turning.features))
    clock = find_offset(joints.stamps, stream.stamps, [still, sliding])
    assert abs(clock.offset - 0.01) < 4 * clock.deviation
    assert clock.shares[0] == 1.0 and clock.shares[1] > 0.9
    with pytest.importorskip('matplotlib').rc_context({'svg.fonttype': 'none'}):
        draw_offset(tmp_path / 'clocks.svg', '/odom', stream, [still, sliding],
                    ('turning', 'sliding'), joints, clock)
    assert re.search('sliding, [xyz]', (tmp_path / 'clocks.svg').read_text())


def recorded(path, offset, seed=0, lost=lambda ns: False, spoilt=slice(0)):
    """Write a bag of joint states and an IMU on the tip, some lost; return its path."""
    types = rec.TYPES.types
    vector, quaternion = types['geometry_msgs/msg/Vector3'], types['geometry_msgs/msg/Quaternion']
    stream = measured(IMU, np.arange(0.003, 8, 0.005), offset, np.random.default_rng(seed))
    stream.values[spoilt, 1] = np.nan
    messages = list(rec.samples(1600))
    for stamp, row in zip(stream.stamps.tolist(), stream.values):
        message = types[IMU](rec.header(stamp, 'imu'), quaternion(0.0, 0.0, 0.0, 1.0),
                             np.zeros(9), vector(*row[:3]), np.zeros(9), vector(*row[3:]),
                             np.zeros(9))
        messages.append(('/imu/data', IMU, stamp, bytes(rec.TYPES.serialize_cdr(message, IMU))))
    kept = [m for m in messages if not lost(m[2] - rec.START)]
    return rec.write_bag(path, sorted(kept, key=lambda m: m[2]))


@pytest.fixture(scope='module')
def sound(tmp_path_factory):
    """Return what writes such a bag, whole, for each offset once."""
    return cache(lambda offset: recorded(tmp_path_factory.mktemp('sound') / 'run', offset))


def test_where_samples_are_lost_nothing_is_made_up(tmp_path, capsys):
    """A listener that stands still for 120 ms three times a second, as on a busy machine."""
    path = recorded(tmp_path / 'run', 0.03, lost=lambda ns: ns // 1e6 % 300 > 180)
    assert check.main(['imu', str(path), '--robot', PUMA, '--topic', '/imu/data']) == 0
    out = capsys.readouterr().out
    shown = float(re.search(r'\(offset ([+-][\d.]+) ms', out)[1])
    assert abs(shown - 30) < 0.5
    left = np.array([float(x) for x in re.search(
        r'specific force is .*; left are ([\d.]+), ([\d.]+), ([\d.]+)', out).groups()])
    np.testing.assert_allclose(left, 0.1, rtol=0.1)


@pytest.mark.parametrize('offset', [0.0, 0.03])
def test_check_imu(offset, sound, capsys):
    path = sound(offset)
    assert check.main(['imu', str(path), '--robot', PUMA, '--topic', '/imu/data']) == 0
    out = capsys.readouterr().out
    shown = float(re.search(r'\(offset ([+-][\d.]+) ms', out)[1]) * 1e-3
    assert abs(shown - offset) < 5e-4
    angles = [float(a) for a in re.search(
        r'roll ([\d.-]+), pitch ([\d.-]+), yaw ([\d.-]+) degrees', out).groups()]
    error = rotation_rpy(*np.radians(angles)) @ TURN
    assert np.degrees(np.linalg.norm(rotation_vector(error))) < 0.2
    # What is left is the IMU's own noise.
    left = np.array([float(x) for x in re.search(
        r'specific force is .*; left are ([\d.]+), ([\d.]+), ([\d.]+)', out).groups()])
    np.testing.assert_allclose(left, 0.1, rtol=0.1)
    assert check.main(['delay', str(path), '--robot', PUMA, '--against', 'imu/data']) == 0
    assert 'early' in capsys.readouterr().out or offset == 0


def test_messages_that_are_not_finite_are_left_out(tmp_path, capsys):
    arguments = ['--robot', PUMA, '--topic', '/imu/data']
    path = recorded(tmp_path / 'some', 0.03, spoilt=slice(None, None, 10))
    assert check.main(['imu', str(path), *arguments]) == 0
    shown = re.search(r'\(offset ([+-][\d.]+) ms', capsys.readouterr().out)[1]
    assert float(shown) == pytest.approx(30, abs=0.5)
    path = recorded(tmp_path / 'all', 0.03, spoilt=slice(None))
    assert check.main(['imu', str(path), *arguments]) == 2
    assert '/imu/data: none of its 1600 messages can be read, or is of finite numbers' in (
        capsys.readouterr().err)


def test_messages_that_are_broken_or_without_stamp_tell_as_much_as_they_can(tmp_path):
    path = recorded(tmp_path / 'run', 0.03)
    with Recording(path) as recording:
        messages = [(m.topic, m.kind, m.received, m.data) for m in recording.messages(
            {rec.JOINT_STATE, 'sensor_msgs/msg/Imu'})]
    imu = [k for k, message in enumerate(messages) if message[0] == '/imu/data']
    for k, data in ((imu[5], lambda data: data[:20]),
                    (imu[9], lambda data: data[:4] + bytes(8) + data[12:])):
        messages[k] = (*messages[k][:3], data(messages[k][3]))
    with Recording(path) as whole, Recording(
            rec.write_bag(tmp_path / 'spoilt', messages)) as spoilt:
        _, stamps, values = read_stream(whole, '/imu/data')
        _, found, left = read_stream(spoilt, '/imu/data')
    stamps[9] = messages[imu[9]][2]
    order = np.argsort(np.delete(stamps, 5))
    np.testing.assert_array_equal(found, np.delete(stamps, 5)[order])
    np.testing.assert_array_equal(left, np.delete(values, 5, axis=0)[order])


def test_what_was_correlated_is_drawn(sound, tmp_path, capsys):
    pytest.importorskip('matplotlib')
    path, picture = sound(0.03), tmp_path / 'clocks.svg'
    assert check.main(['delay', str(path), '--robot', PUMA, '--against', 'imu/data', '--plot',
                       str(picture)]) == 0
    assert 'set robot.stamp_offset: -0.0' in capsys.readouterr().out
    assert picture.read_text().count('<path') > 20


@pytest.mark.parametrize('arguments, message', [
    (['--against', '/imu/data', '--plot', 'clocks.txt'], "'clocks.txt'; allowed: a file end"),
    (['--against', '/nothing'], '/nothing has messages of type none; allowed: sensor_msgs'),
    (['--against', '/joint_states'], 'has messages of type sensor_msgs/msg/JointState; allowed'),
    (['--against', '/imu/data', '--tip', 'hand'], "hand")])
def test_check_delay_says_what_is_wrong(arguments, message, sound, capsys):
    path = sound(0.0)
    assert check.main(['delay', str(path), '--robot', PUMA, *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count('\n') == 1

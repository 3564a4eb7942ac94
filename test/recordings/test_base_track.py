# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded mobile manipulator: states in the frame of its odometry."""
import math

import numpy as np
import pytest
from screw_kinematics.pipeline.parameter_file import read_robots
from screw_kinematics.recordings.link_motion import link_motion
from screw_kinematics.recordings.processing import process, Task
from screw_kinematics.recordings.recording import Recording
from screw_kinematics.recordings.sources import find_sources
from screw_kinematics.recordings.tables import read_history
from screw_kinematics.screws.body_state import BodyState
from screw_kinematics.screws.exponential import exp
from screw_kinematics.screws.rotations import quaternion_from_rotation
from screw_kinematics.tools.bag import main as bag
from screw_kinematics.tools.view.recorded import recorded_motions
from support import recordings as rec

TWIST, ODOMETRY = 'geometry_msgs/msg/TwistStamped', 'nav_msgs/msg/Odometry'
SCREW = np.array([0.1, 0.0, 0.9, 1.0, 0.0, 0.2])


def phase(t, n):
    """Return the n-th derivative of the way along the screw."""
    return 0.5 * 1.3**n * math.sin(1.3 * t + n * math.pi / 2)


def message(kind):
    return rec.TYPES.types[kind]


def odometry(stamp, frame='base', twist=None, world='odom'):
    t = (stamp - rec.START) * 1e-9
    place = exp(phase(t, 0) * SCREW)
    vector, point = message('geometry_msgs/msg/Vector3'), message('geometry_msgs/msg/Point')
    u = phase(t, 1) * SCREW if twist is None else np.array(twist)
    velocity = message('geometry_msgs/msg/Twist')(vector(*u[3:]), vector(*u[:3]))
    if not world:
        return rec.TYPES.serialize_cdr(message(TWIST)(rec.header(stamp, frame), velocity), TWIST)
    pose = message('geometry_msgs/msg/Pose')(
        point(*place[:3, 3]),
        message('geometry_msgs/msg/Quaternion')(*quaternion_from_rotation(place[:3, :3])))
    return rec.TYPES.serialize_cdr(message(ODOMETRY)(
        rec.header(stamp, world), frame,
        message('geometry_msgs/msg/PoseWithCovariance')(pose, np.zeros(36)),
        message('geometry_msgs/msg/TwistWithCovariance')(velocity, np.zeros(36))), ODOMETRY)


def recorded(tmp_path, of_base, seconds=4.0):
    """Return a bag of the PUMA's joints and a base's messages, and a file of parameters."""
    messages = [*rec.samples(int(200 * seconds)), *of_base]
    path = rec.write_bag(tmp_path / 'run', sorted(messages, key=lambda m: m[2]))
    file = tmp_path / 'params.yaml'
    file.write_text(f"""
kinematic_state_publisher:
  ros__parameters:
    robots: [puma]
    puma: {{description: {rec.ROBOTS / 'puma560.yaml'}, base_motion_topic: odom}}
""")
    return path, file


def of_base(seconds=4.0, rate=40, kind=ODOMETRY, **more):
    for k in range(int(rate * seconds)):
        stamp = rec.START + k * 10**9 // rate
        yield '/odom', kind, stamp + 1000, odometry(stamp, **more)


def exact(stamps, pose=True):
    """Return the exact states of the tool."""
    for stamp in stamps:
        t = (stamp - rec.START) * 1e-9
        place = exp(phase(t, 0) * SCREW) if pose else np.eye(4)
        u = [phase(t, n) * SCREW for n in (1, 2)]
        seat = BodyState(place, tuple(u), place[:3, 3], 'tip', 'tip')
        yield seat.followed_by(rec.PUMA.state(*rec.MOTION.derivatives(t, 2)))


@pytest.mark.parametrize('kind, world', [(ODOMETRY, 'odom'), (TWIST, '')])
def test_states_are_relative_to_the_frame_of_the_odometry(tmp_path, kind, world):
    path, file = recorded(tmp_path, of_base(kind=kind, world=world, frame='base'))
    assert bag.main([str(path), '--params-file', str(file), '--outputs', 'pose,twist,accel',
                     '--output', str(tmp_path / 'x.parquet')]) == 0
    history = read_history(tmp_path / 'x.parquet', ('pose', 'twist', 'accel'))
    assert history.base_frame == (world or 'base') and len(history.time) > 700
    inside = (history.time > 0.2) & (history.time < 3.7)
    stamps = history.start + np.rint(history.time[inside] * 1e9).astype(int)
    known = list(exact(stamps[::10], pose=bool(world)))
    for name, value, bound in (('pose', lambda s: s.pose, 1e-4),
                               ('twist', lambda s: s.velocity, 2e-3),
                               ('accel', lambda s: s.classical(2), 5e-2)):
        np.testing.assert_allclose(history.values[name][inside][::10],
                                   [value(state) for state in known], atol=bound)


def test_outputs_with_covariance_know_the_base_too(tmp_path):
    path, file = recorded(tmp_path, of_base())
    assert bag.main([str(path), '--params-file', str(file), '--outputs',
                     'twist,accel_with_covariance', '--output', str(tmp_path / 'out')]) == 0
    messages = rec.read_bag(tmp_path / 'out')
    assert set(messages) == {'/puma/twist', '/puma/accel_with_covariance'}
    assert {m.header.frame_id for topic in messages.values() for _, m in topic} == {'odom'}
    covariances = [m.accel.covariance for _, m in messages['/puma/accel_with_covariance']]
    assert len(covariances) > 700 and np.isfinite(covariances).all()
    assert (np.array(covariances).reshape(-1, 6, 6)[:, range(6), range(6)] > 0).all()


def test_where_the_odometry_is_missing_there_are_no_states(tmp_path, capsys):
    half = [m for m in of_base() if m[2] < rec.START + 2 * 10**9]
    wrong = [('/odom', ODOMETRY, rec.START + 5, odometry(rec.START + 4, frame='wheels'))]
    path, file = recorded(tmp_path, [*half, *wrong])
    assert bag.main([str(path), '--params-file', str(file), '--outputs', 'twist',
                     '--output', str(tmp_path / 'x.csv')]) == 0
    told = capsys.readouterr().out
    assert 'base_motion_too_old' in told
    assert "1 messages of the base refused: frame_not_fixed_to_base (the moving frame is" in told
    history = read_history(tmp_path / 'x.csv', ('twist',))
    assert 2.4 < history.time[-1] < 2.6     # stale_timeout


@pytest.mark.parametrize('messages, words', [
    ([], 'no motion of a base on /odom'),
    (list(of_base(frame='wheels')), "the moving frame is 'wheels'; allowed: 'base'"),
    (list(of_base(0.1)), 'too few')])
def test_a_base_of_which_nothing_is_known_is_named(tmp_path, capsys, messages, words):
    path, file = recorded(tmp_path, messages)
    assert bag.main([str(path), '--params-file', str(file), '--outputs', 'twist',
                     '--output', str(tmp_path / 'x.csv')]) != 0
    assert words in ''.join(capsys.readouterr())


def test_a_twist_in_wrong_axes_is_found(tmp_path, capsys):
    turned = [('/odom', ODOMETRY, rec.START + k * 25_000_000,
               odometry(rec.START + k * 25_000_000, twist=np.zeros(6))) for k in range(160)]
    path, file = recorded(tmp_path, turned)
    assert bag.main([str(path), '--params-file', str(file), '--outputs', 'twist',
                     '--output', str(tmp_path / 'x.csv')]) == 0
    assert 'does not tell how its pose moves' in capsys.readouterr().out


def test_whatever_is_made_of_a_recording_knows_the_base(tmp_path):
    path, file = recorded(tmp_path, of_base())
    robot, = read_robots(file)
    with Recording(path) as recording:
        link = link_motion(recording, robot, '')
    inside = slice(100, -100, 50)
    states = list(exact(link.stamps[inside]))
    for found, value, bound in (
            (link.position, lambda s: s.pose[:3, 3], 1e-4),
            (link.rotation, lambda s: s.pose[:3, :3], 1e-4),
            (link.velocity, lambda s: s.velocity[3:], 2e-3),
            (link.angular_velocity, lambda s: s.velocity[:3], 2e-3),
            (link.acceleration, lambda s: s.classical(2)[3:], 5e-2)):
        np.testing.assert_allclose(found[inside], [value(s) for s in states], atol=bound)

    motion, = recorded_motions(str(path), [robot], '')
    assert motion.world == 'odom'
    snapshots = motion.snapshots[20:-20:20]
    # Without the offset of the first state the times would be those of the stamps.
    start = link.stamps[0]
    for snapshot, state in zip(snapshots, exact([start + 1e9 * s.time for s in snapshots])):
        np.testing.assert_allclose(snapshot.pose, state.pose, atol=1e-4)
        np.testing.assert_allclose(snapshot.accel, state.classical(2), atol=5e-2)
        np.testing.assert_allclose(snapshot.skeleton[0][-1], snapshot.pose[:3, 3], atol=1e-12)
        np.testing.assert_allclose(snapshot.skeleton[0][0], snapshot.base[:3, 3], atol=1e-12)
        np.testing.assert_allclose(
            snapshot.base, exp(phase((start - rec.START) * 1e-9 + snapshot.time, 0) * SCREW),
            atol=1e-4)
        assert np.linalg.eigvalsh(snapshot.covariance).min() > -1e-12

    outcome = process(Task(find_sources([str(path)])[0], (robot,), stop_limit=5.0))
    summary = outcome.robots[0].summary
    assert summary.peaks['speed'][0] == pytest.approx(
        np.linalg.norm(link.velocity, axis=1).max(), rel=1e-9)
    np.testing.assert_allclose(summary.high, link.position.max(axis=0), rtol=1e-12)

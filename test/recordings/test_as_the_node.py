# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One rule, live and recorded: what is refused, which velocity counts, what is plausible."""
import numpy as np
import pytest

from screw_kinematics.errors import ParameterError, ToolError
from screw_kinematics.pipeline.parameter_file import matches, read_robots
from screw_kinematics.recordings.tables import read_history
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')


def params(path, settings='', node='kinematic_state_publisher'):
    """Write a parameter file for one robot; return its path."""
    path.write_text(f"""
{node}:
  ros__parameters:
    robots: [puma]
    puma:
      description: {PUMA}
{settings}""")
    return path


def states(tmp_path, messages, settings, quantities=('twist', 'accel')):
    """Return the states that the tool makes of messages."""
    recording = rec.write_bag(tmp_path / 'run', messages)
    file = params(tmp_path / 'params.yaml', settings)
    code = bag.main([str(recording), '--params-file', str(file), '--outputs',
                     ','.join(quantities), '--output', str(tmp_path / 'x.parquet')])
    return code, (read_history(tmp_path / 'x.parquet', quantities) if code == 0 else None)


def with_velocities(count, change, rate=200.0):
    """Yield joint states whose velocities are altered."""
    for k, (topic, kind, received, data) in enumerate(rec.samples(count, rate)):
        sample = rec.TYPES.deserialize_cdr(data, kind)
        yield topic, kind, received, rec.joint_state(
            rec.stamp_of(sample), sample.name, sample.position, change(k, sample.velocity))


def test_measured_velocities_are_passed_on(tmp_path):
    """Twice the true velocity: believed, for good or bad, when the parameter says so."""
    code, history = states(tmp_path, with_velocities(600, lambda k, qd: 2 * qd),
                           '      velocity_source: measured')
    assert code == 0
    exact = rec.exact(history.start + np.rint(history.time * 1e9)).classical(1)
    np.testing.assert_allclose(history.values['twist'], 2 * exact, atol=1e-4)


@pytest.mark.parametrize('outputs, bound', [(('twist',), 1e-4), (('twist', 'accel'), 2e-2)])
def test_samples_without_a_measured_velocity_are_refused(outputs, bound, tmp_path, capsys):
    code, history = states(
        tmp_path, with_velocities(600, lambda k, qd: qd if k % 10 else qd * np.nan),
        '      velocity_source: measured', outputs)
    assert code == 0 and len(history.time) == 540
    assert '60 velocity_not_measured' in capsys.readouterr().out
    exact = rec.exact(history.start + np.rint(history.time * 1e9)).classical(len(outputs))
    assert rec.relative_error(history.values[outputs[-1]], exact) < bound


def test_the_measured_are_used_however_seldom_they_come(tmp_path, capsys):
    """Three samples a second: nothing is estimated, so no pause is too long."""
    code, history = states(tmp_path, rec.samples(60, rate=3.0),
                           '      velocity_source: measured', ('twist',))
    assert code == 0 and len(history.time) == 60


@pytest.mark.parametrize('rate', [1.0, 2.0, 3.0, 3.9])
def test_a_slow_recording_is_explained_and_leaves_nothing(rate, tmp_path, capsys):
    code, _ = states(tmp_path, rec.samples(60, rate=rate), '')
    assert code == 1
    error = capsys.readouterr().err
    assert f'samples come every {1 / rate:.3g} s, and pauses that exceed ' \
           'puma.estimator.max_gap (0.25 s)' in error
    assert sorted(path.name for path in tmp_path.iterdir()) == ['params.yaml', 'run']
    if rate < 3:
        return
    raised = params(tmp_path / 'params.yaml', '      estimator: {max_gap: 1.5}')
    assert bag.main([str(tmp_path / 'run'), '--params-file', str(raised),
                     '--output', str(tmp_path / 'y.csv')]) == 0


def test_joints_that_come_seldom_explain_why_there_are_no_states(tmp_path, capsys):
    """As of a gripper that sends once a second, beside an arm."""
    arm = rec.samples(1000, rate=200.0, joints=slice(0, 5))
    gripper = rec.samples(5, rate=1.0, joints=slice(5, 6))
    code, _ = states(tmp_path, sorted([*arm, *gripper], key=lambda m: m[2]), '')
    assert code == 1
    assert 'samples come every 1 s, and pauses that exceed' in capsys.readouterr().err


def test_the_greatest_velocity_is_the_nodes(tmp_path, capsys):
    """A joint that turns at 30 rad/s: refused by default, as by the node."""
    def fast():
        names = rec.PUMA.joint_names
        for k in range(400):
            stamp = rec.START + k * 5_000_000
            q = np.zeros(6)
            q[0] = 30.0 * k * 0.005
            yield '/joint_states', rec.JOINT_STATE, stamp, rec.joint_state(stamp, names, q)
    code, _ = states(tmp_path, fast(), '')
    assert code == 1 and '400 implausible_jump' in capsys.readouterr().out
    raised = params(tmp_path / 'params.yaml', '      estimator: {max_velocity: 100.0}')
    assert bag.main([str(tmp_path / 'run'), '--params-file', str(raised), '--force',
                     '--output', str(tmp_path / 'y.parquet')]) == 0
    assert 'implausible_jump' not in capsys.readouterr().out
    twist = read_history(tmp_path / 'y.parquet', ['twist']).values['twist']
    np.testing.assert_allclose(twist[50:-50, 2], 30.0, rtol=1e-3)


@pytest.mark.parametrize('pattern, node, matched', [
    ('kinematic_state_publisher', '/kinematic_state_publisher', True),
    ('kinematic_state_publisher', '/cell/kinematic_state_publisher', False),
    ('/cell/kinematic_state_publisher', '/cell/kinematic_state_publisher', True),
    ('/*/kinematic_state_publisher', '/cell/kinematic_state_publisher', True),
    ('/*/kinematic_state_publisher', '/kinematic_state_publisher', False),
    ('/*', '/kinematic_state_publisher', True),
    ('/*', '/cell/kinematic_state_publisher', False),
    ('/cell/*', '/cell/kinematic_state_publisher', True),
    ('/**', '/a/b/kinematic_state_publisher', True),
    ('/**/kinematic_state_publisher', '/kinematic_state_publisher', True),
    ('/**/cell/kinematic_state_publisher', '/a/b/cell/kinematic_state_publisher', True),
    ('/**/cell/kinematic_state_publisher', '/a/b/kinematic_state_publisher', False)])
def test_names_of_nodes_in_parameter_files(pattern, node, matched):
    """As rcl 9.2 matches them."""
    assert matches(pattern, node) == matched


def test_parameter_files_by_namespace(tmp_path):
    file = tmp_path / 'params.yaml'
    file.write_text(f"""
/**:
  ros__parameters: {{robots: [puma], puma: {{description: {PUMA}, base_frame: base}},
                    use_sim_time: true, qos_overrides: {{/clock: {{subscription: {{depth: 9}}}}}}}}
/cell:
  kinematic_state_publisher:
    ros__parameters: {{puma: {{stale_timeout: 2.0}}}}
/*/kinematic_state_publisher:
  ros__parameters: {{puma: {{stale_timeout: 3.0, markers_rate: 7.0}}}}
""")
    robot, = read_robots(file, namespace='cell')
    # What is last in the file wins, as in ROS.
    assert (robot.base_frame, robot.stale_timeout, robot.markers_rate) == ('base', 3.0, 7.0)
    robot, = read_robots(file)
    assert (robot.base_frame, robot.stale_timeout) == ('base', 0.5)
    only = params(tmp_path / 'cell.yaml', node='/cell/kinematic_state_publisher')
    with pytest.raises(ToolError, match='no parameters of the node /kinematic_state_publisher; '
                       'there are those of /cell/kinematic_state_publisher; is the namespace'):
        read_robots(only)
    assert read_robots(only, namespace='/cell/')[0].name == 'puma'
    wrong = params(tmp_path / 'wrong.yaml', '      stale_timeuot: 1.0')
    with pytest.raises(ParameterError, match="puma.stale_timeout"):
        read_robots(wrong)


def test_nothing_is_overwritten_unasked(tmp_path, capsys):
    recording = rec.write_bag(tmp_path / 'run', rec.samples(100))
    for name in ('x.csv', 'out'):
        arguments = [str(recording), '--robot', PUMA, '--output', str(tmp_path / name)]
        assert bag.main(arguments) == 0
        assert bag.main(arguments) == 2
        assert 'exists already; choose another output, or --force' in capsys.readouterr().err
        assert bag.main([*arguments, '--force']) == 0
    assert not list(tmp_path.glob('.*'))

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""States out of recordings are those of the motion that was recorded."""
import itertools
import re
import shutil

import numpy as np
import pytest

from screw_kinematics.messages.stamped import TwistEncoder
from screw_kinematics.motion import make_estimator
from screw_kinematics.recordings import blocks
from screw_kinematics.recordings.tables import read_history
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')
COUNT = 2000


@pytest.fixture(scope='module', params=['mcap', 'sqlite3'])
def recording(request, tmp_path_factory):
    """Return a bag of 10 s at 200 Hz in either storage."""
    path = tmp_path_factory.mktemp(request.param) / 'run'
    return rec.write_bag(path, rec.samples(COUNT), request.param)


@pytest.fixture
def run(tmp_path):
    """Return a bag of 5 s."""
    return rec.write_bag(tmp_path / 'run', rec.samples(1000))


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_bag_with_the_topics_of_the_node(recording, storage, tmp_path, capsys):
    arguments = [str(recording), '--robot', PUMA, '--name', 'puma', '--storage', storage,
                 '--outputs', 'pose,twist,accel,jerk', '--output', str(tmp_path / 'out')]
    assert bag.main(arguments) == 0
    out = capsys.readouterr().out
    assert f'{COUNT} joint samples on /joint_states, {COUNT} states' in out
    found = rec.read_bag(tmp_path / 'out')
    assert set(found) == {f'/puma/{name}' for name in ('pose', 'twist', 'accel', 'jerk')}
    stamps = [rec.stamp_of(message) for _, message in found['/puma/twist']]
    assert stamps == [rec.START + round(k / 200 * 1e9) for k in range(COUNT)]
    assert all(received == stamp + 300_000
               for stamp, (received, _) in zip(stamps, found['/puma/accel']))
    assert {message.header.frame_id for _, message in found['/puma/twist']} == {'base'}
    state = rec.exact(stamps, 3)
    pose = [[m.pose.position.x, m.pose.position.y, m.pose.position.z]
            for _, m in found['/puma/pose']]
    assert rec.relative_error(pose, state.pose[:, :3, 3]) < 1e-5
    for topic, part, order, bound in (('twist', 'twist', 1, 1e-3), ('accel', 'accel', 2, 5e-3),
                                      ('jerk', 'accel', 3, 0.1)):
        values = [rec.six(getattr(m, part)) for _, m in found[f'/puma/{topic}']]
        assert rec.relative_error(values, state.classical(order)) < bound


@pytest.mark.parametrize('ending', ['.csv', '.parquet'])
def test_tables(run, ending, tmp_path):
    output = tmp_path / f'states{ending}'
    assert bag.main([str(run), '--robot', PUMA, '--outputs', 'pose,accel',
                     '--output', str(output)]) == 0
    history = read_history(output, ['pose', 'accel'])
    assert history.start == rec.START
    if ending == '.parquet':
        assert (history.name, history.base_frame, history.tip_frame) == ('robot', 'base', 'tool')
    state = rec.exact(history.start + np.rint(history.time * 1e9).astype(np.int64))
    assert rec.relative_error(history.values['pose'], state.pose) < 1e-5
    assert rec.relative_error(history.values['accel'], state.classical(2)) < 5e-3


def test_joints_in_different_messages_of_different_topics(tmp_path, capsys):
    arm = rec.samples(1000, joints=slice(0, 4), topic='/lab/arm/joint_states')
    wrist = rec.samples(500, rate=100.0, joints=slice(4, 6), offset=1_234_567,
                        topic='/lab/wrist/joint_states')
    path = rec.write_bag(tmp_path / 'run', sorted(itertools.chain(arm, wrist),
                                                  key=lambda message: message[2]))
    params = tmp_path / 'params.yaml'
    params.write_text(f"""
/lab/kinematic_state_publisher:
  ros__parameters:
    robots: [whole, tilted]
    whole:
      description: {PUMA}
      joint_states_topic: [arm/joint_states, wrist/joint_states]
    tilted:
      description: {PUMA}
      joint_states_topic: [arm/joint_states, wrist/joint_states]
      outputs: [accel]
      expressed_in: tip
      estimator: {{delay: 0.02}}
""")
    assert bag.main([str(path), '--params-file', str(params), '--namespace', 'lab',
                     '--output', str(tmp_path / 'out')]) == 0
    found = rec.read_bag(tmp_path / 'out')
    assert set(found) == {'/lab/whole/twist', '/lab/whole/accel', '/lab/tilted/accel'}
    for topic, axes in (('/lab/whole/accel', 'base'), ('/lab/tilted/accel', 'tip')):
        stamps = [rec.stamp_of(message) for _, message in found[topic]]
        # At the rate of the joints that come most often, as the node does it.
        assert len(stamps) > 980 and np.all(np.diff(stamps) > 0)
        values = [rec.six(message.accel) for _, message in found[topic]]
        state = rec.exact(stamps).expressed_in(axes)
        assert rec.relative_error(values, state.classical(2)) < 5e-3
    assert found['/lab/tilted/accel'][0][1].header.frame_id == 'tool'


@pytest.mark.parametrize('name', ['states.csv.gz', 'states.bag', 'states.xlsx'])
def test_an_ending_that_is_not_written_is_no_folder(run, name, tmp_path, capsys):
    assert bag.main([str(run), '--robot', PUMA, '--output', str(tmp_path / name)]) == 2
    assert 'allowed: a file ending in .csv or .parquet, or the folder of a bag' in (
        capsys.readouterr().err)
    assert not (tmp_path / name).exists()


def test_what_a_table_has_no_columns_for_is_named(run, tmp_path, capsys):
    arguments = [str(run), '--robot', PUMA, '--outputs', 'twist,joint_motion', '--output']
    assert bag.main([*arguments, str(tmp_path / 'states.csv')]) == 0
    assert 'robot: not in tables, but in bags: joint_motion\n' in capsys.readouterr().out
    assert bag.main([*arguments, str(tmp_path / 'states')]) == 0
    assert 'not in tables' not in capsys.readouterr().out


def test_several_recordings_go_to_a_folder(run, tmp_path, capsys):
    shutil.copytree(run, tmp_path / 'again')
    assert bag.main([str(run), str(tmp_path / 'again'), '--robot', PUMA,
                     '--output', str(tmp_path / 'states.csv')]) == 2
    assert "states.csv'; allowed: a folder" in capsys.readouterr().err


def test_seams_of_blocks_do_not_show(run, tmp_path, monkeypatch):
    values = []
    for name, size in (('whole', 10_000), ('pieces', 300)):
        monkeypatch.setattr(blocks, 'BLOCK', size)
        output = tmp_path / f'{name}.parquet'
        assert bag.main([str(run), '--robot', PUMA, '--processes', '1',
                         '--output', str(output)]) == 0
        values.append(read_history(output, ['accel']).values['accel'])
    exact = rec.exact(rec.START + np.rint(np.arange(1000) / 200 * 1e9)).classical(2)
    whole, pieces = (rec.relative_error(found, exact) for found in values)
    assert pieces < 1.2 * whole < 5e-3


def test_joints_that_come_as_often_do_not_take_turns_at_seams(tmp_path, monkeypatch):
    """Two drivers of one rate, nearly: states are at the instants of one of them throughout."""
    monkeypatch.setattr(blocks, 'BLOCK', 131)
    parts = [rec.samples(count, rate=rate, joints=joints) for count, rate, joints in (
        (1000, 100.0, slice(0, 4)), (1003, 100.3, slice(4, 6)))]
    path = rec.write_bag(tmp_path / 'run', sorted(
        itertools.chain(*parts), key=lambda message: message[2]))
    assert bag.main([str(path), '--robot', PUMA, '--processes', '1',
                     '--output', str(tmp_path / 'states.csv')]) == 0
    steps = np.diff(read_history(tmp_path / 'states.csv', ['accel']).time)
    np.testing.assert_allclose(steps, 0.01, rtol=1e-5)


def test_two_processes_give_what_one_gives(run, tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, 'BLOCK', 300)
    tables = []
    for count in '12':
        tables.append(tmp_path / f'{count}.csv')
        assert bag.main([str(run), '--robot', PUMA, '--processes', count,
                         '--output', str(tables[-1])]) == 0
    assert tables[0].read_bytes() == tables[1].read_bytes()


def test_unusable_samples_are_counted(tmp_path, capsys):
    messages = list(rec.samples(600))
    names, broken = rec.PUMA.joint_names, [0.1, np.nan, 0, 0, 0, 0]
    stamp = messages[300][2]
    odd = [rec.joint_state(stamp + 1000, names, broken),
           rec.joint_state(stamp + 2000, names, [0.0] * 2),
           rec.joint_state(stamp + 3000, ['lamp'], [0.0]), b'\0\1\0\0short']
    messages[301:301] = [('/joint_states', rec.JOINT_STATE, stamp, data) for data in odd]
    path = rec.write_bag(tmp_path / 'run', messages)
    assert bag.main([str(path), '--robot', PUMA, '--output', str(tmp_path / 'x.csv')]) == 0
    out = capsys.readouterr().out
    assert '604 joint samples' in out and ' 600 states' in out
    for reason in ('1 position_not_finite (q2 at nan)', '1 position_of_wrong_length',
                   '1 no_joint_of_robot', '1 malformed_message'):
        assert reason in out


def test_the_accuracy_told_is_not_that_of_the_first_instants(tmp_path, capsys):
    """Of slow samples the ends of a run are hardly known; what is told is of all the others."""
    def messages():
        for k in range(60):
            stamp = rec.START + round(k / 3 * 1e9)
            q = 0.5 * np.sin(0.5 * k / 3 + np.arange(6))
            yield '/joint_states', rec.JOINT_STATE, stamp, rec.joint_state(
                stamp, rec.PUMA.joint_names, np.round(q / rec.QUANTUM) * rec.QUANTUM)
    path = rec.write_bag(tmp_path / 'run', messages())
    parameters = tmp_path / 'parameters.yaml'
    parameters.write_text(
        f'/**: {{ros__parameters: {{robots: [arm], arm: {{description: {PUMA}, '
        'estimator: {max_gap: 1.0}}}}')
    assert bag.main([str(path), '--params-file', str(parameters), '--output',
                     str(tmp_path / 'x.csv')]) == 0
    out = capsys.readouterr().out
    told = re.search(r'right to ([\d.e+-]+) rad/s2 \(([\d.]+) %\)', out)
    assert told and float(told[1]) < 0.1, out


def test_the_model_may_be_in_the_recording(tmp_path):
    urdf = """<robot name="arm"><link name="a"/><link name="b"/>
      <joint name="q1" type="revolute"><parent link="a"/><child link="b"/>
      <axis xyz="0 0 1"/><limit effort="1" velocity="1" lower="-1" upper="1"/></joint></robot>"""
    kind = 'std_msgs/msg/String'
    text = bytes(rec.TYPES.serialize_cdr(rec.TYPES.types[kind](urdf), kind))
    path = rec.write_bag(tmp_path / 'run', [('/robot_description', kind, rec.START, text),
                                            *rec.samples(600)])
    params = tmp_path / 'params.yaml'
    params.write_text('/**:\n  ros__parameters:\n    robots: [arm]\n')
    assert bag.main([str(path), '--params-file', str(params),
                     '--output', str(tmp_path / 'x.csv')]) == 0
    twist = read_history(tmp_path / 'x.csv', ['twist']).values['twist']
    exact = rec.MOTION.derivatives(np.arange(600) / 200, 1)[1][:, 0]
    assert rec.relative_error(twist[:, 2], exact) < 1e-3


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_metadata_that_was_never_written(storage, tmp_path, capsys):
    path = rec.write_bag(tmp_path / 'run', rec.samples(600), storage)
    (path / 'metadata.yaml').unlink()
    assert bag.main([str(path), '--robot', PUMA, '--output', str(tmp_path / 'x.csv')]) == 1
    captured = capsys.readouterr()
    assert ' 600 states' in captured.out
    assert 'damaged' in captured.err and '600 joint samples were saved' in captured.err


def test_compare_with_what_the_node_published(tmp_path, capsys):
    estimator = make_estimator('bank', 6, delay=0.02)
    program = rec.PUMA.compile(('twist', 'accel'))
    encode = TwistEncoder('base').encode
    messages = []
    for topic, kind, received, data in rec.samples(1500):
        messages.append((topic, kind, received, data))
        sample = rec.TYPES.deserialize_cdr(data, rec.JOINT_STATE)
        stamp = rec.stamp_of(sample)
        motion = estimator.update((stamp - rec.START) * 1e-9, sample.position, sample.velocity)
        if motion is None:
            continue
        states = program(motion.position, motion.velocity, motion.acceleration)
        at = rec.START + round(motion.stamp * 1e9)
        for name in ('twist', 'accel'):
            messages.append((f'/puma/{name}', f'geometry_msgs/msg/{name.capitalize()}Stamped',
                             received + 1000, encode(at, states[name].tolist())))
    path = rec.write_bag(tmp_path / 'run', messages)
    assert bag.main([str(path), '--robot', PUMA, '--name', 'puma', '--compare']) == 0
    out = capsys.readouterr().out
    published = rec.read_bag(path)
    for name, order in (('twist', 1), ('accel', 2)):
        row = re.search(rf'^/puma/{name} +(\d+) +(\d+) +(\S+) +(\S+) ', out, re.MULTILINE)
        received, compared, angular, linear = map(float, row.groups())
        assert received > 1400 and compared > 0.99 * received
        # The smoother is so much better that the difference is the node's error.
        stamps = [rec.stamp_of(message) for _, message in published[f'/puma/{name}']]
        values = np.array([rec.six(getattr(m, name)) for _, m in published[f'/puma/{name}']])
        error = (values - rec.exact(stamps).classical(order))**2
        assert angular == pytest.approx(np.sqrt(error[:, :3].sum(axis=1).mean()), rel=0.2)
        assert linear == pytest.approx(np.sqrt(error[:, 3:].sum(axis=1).mean()), rel=0.2)


def test_robots_of_other_topics_are_done_where_one_was_not_recorded(run, tmp_path, capsys):
    params = tmp_path / 'params.yaml'
    params.write_text(f"""
/**:
  ros__parameters:
    robots: [one, left]
    one: {{description: {PUMA}}}
    left: {{description: {PUMA}, joint_states_topic: left/joint_states}}
""")
    page = tmp_path / 'new' / 'page.html'
    arguments = [str(run), '--params-file', str(params), '--report', str(page),
                 '--output', str(tmp_path / 'out')]
    assert bag.main(arguments) == 1
    printed = capsys.readouterr()
    assert '1000 joint samples on /joint_states, 1000 states' in printed.out
    told = f'{run}: no joint states on /left/joint_states; topics of that type: /joint_states'
    assert printed.err == f'bag: left: no state: {told}\n'
    assert told in page.read_text()
    assert set(rec.read_bag(tmp_path / 'out')) == {'/one/twist', '/one/accel'}
    params.write_text(params.read_text().replace('left/joint', 'right/joint'))
    assert bag.main([*arguments, '--force', '--format', 'dataset']) == 1


def test_joints_that_nobody_publishes_and_what_is_published(run, tmp_path, capsys):
    other = str(rec.ROBOTS / 'panda.yaml')
    assert bag.main([str(run), '--robot', other, '--output', str(tmp_path / 'out')]) == 1
    assert re.search(r'no joint states of .*; there are some of ', capsys.readouterr().err)


def test_nothing_to_compare_is_a_finding(run, tmp_path, capsys):
    assert bag.main([str(run), '--robot', PUMA, '--compare']) == 1
    table = tmp_path / 'x.csv'
    table.write_text('\n'.join([','.join(['t', *rec.PUMA.joint_names]), *(
        f'{0.01 * k:.2f}' + f',{np.sin(0.01 * k):.6f}' * 6 for k in range(50))]))
    assert bag.main([str(table), '--robot', PUMA, '--compare']) == 1
    assert 'nothing to compare: no output of the node is in a table' in capsys.readouterr().out


@pytest.mark.parametrize('change, message', [
    (['--topic', 'joints'], 'no joint states on /joints; topics of that type: /joint_states'),
    (['--robot', 'no.yaml'], 'no.yaml'),
    (['--outputs', 'speed'], "parameter 'robot.outputs' is .'speed'.; allowed: a list of pose"),
    (['--output', ''], 'exists already'),
])
def test_errors_are_one_line(run, tmp_path, capsys, change, message):
    options = {'--robot': PUMA, '--output': str(tmp_path / 'out'), **dict([change])}
    options['--output'] = options['--output'] or str(run)
    assert bag.main([str(run), *itertools.chain(*options.items())]) == 2
    error = capsys.readouterr().err
    assert re.search(message, error) and error.count('\n') == 1


def test_the_motion_of_the_joints_and_an_imu_with_covariances(run, tmp_path):
    outputs = ('joint_motion', 'joint_states', 'imu', 'accel_with_covariance')
    assert bag.main([str(run), '--robot', PUMA, '--outputs', ','.join(outputs),
                     '--output', str(tmp_path / 'out')]) == 0
    found = rec.read_bag(tmp_path / 'out')
    assert {topic: len(messages) for topic, messages in found.items()} == {
        f'/robot/{output}': 1000 for output in outputs}
    stamps = [rec.stamp_of(message) for _, message in found['/robot/imu']]
    q, qd, qdd = rec.MOTION.derivatives((np.array(stamps) - rec.START) * 1e-9, 2)
    points = [message.points[0] for _, message in found['/robot/joint_motion']]
    for part, exact in (('positions', q), ('velocities', qd), ('accelerations', qdd)):
        assert rec.relative_error([getattr(p, part) for p in points], exact) < 5e-3
    assert rec.relative_error([m.velocity for _, m in found['/robot/joint_states']], qd) < 1e-3
    state = rec.exact(stamps)
    felt = np.einsum('nji,nj->ni', state.pose[:, :3, :3],
                     state.classical(2)[:, 3:] + [0, 0, 9.80665])
    imu = [m.linear_acceleration for _, m in found['/robot/imu']]
    assert rec.relative_error([[a.x, a.y, a.z] for a in imu], felt) < 2e-3
    for topic, values in (('imu', lambda m: m.linear_acceleration_covariance),
                          ('accel_with_covariance', lambda m: m.accel.covariance)):
        covariances = np.array([values(m) for _, m in found[f'/robot/{topic}']])
        assert np.isfinite(covariances).all() and (covariances[:, 0] > 0).all()

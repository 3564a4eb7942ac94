# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Tables of joint samples: whatever they look like, the same samples; or a question."""
import csv
import gzip

import numpy as np
import pyarrow
from pyarrow import parquet
import pytest

from screw_kinematics.errors import ParameterError, ToolError
from screw_kinematics.recordings.joint_table import JointTable, TableFormat
from screw_kinematics.recordings.tables import read_history
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')
JOINTS = {'shoulder_1': 'revolute', 'shoulder_10': 'revolute', 'slide': 'prismatic'}
START = rec.START


def motion(count, rate=200.0):
    """Return stamps [ns], positions and velocities."""
    stamps = [START + round(k / rate * 1e9) for k in range(count)]
    t = (np.array(stamps) - START) * 1e-9
    q = np.stack([np.sin(t), 0.5 * np.cos(2 * t), 0.3 * np.sin(3 * t)], axis=1)
    qd = np.stack([np.cos(t), -np.sin(2 * t), 0.9 * np.cos(3 * t)], axis=1)
    return stamps, q, qd


def write(path, names, columns):
    """Write a table, CSV or Parquet by its ending; return its path."""
    if path.suffix == '.parquet':
        parquet.write_table(pyarrow.table(dict(zip(names, columns))), path)
        return path
    with (gzip.open if path.suffix == '.gz' else open)(path, 'wt', newline='') as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows(zip(*columns))
    return path


def samples(path, stated=None, joints=None):
    """Return stamps, positions and velocities that are read."""
    found = [sample for _, _, sample in JointTable(path, stated).samples(joints or JOINTS)]
    return ([s.stamp_ns for s in found], np.array([s.position for s in found]),
            np.array([s.velocity for s in found]))


def agree(path, stated=None, velocity=True, first=START, tolerance=1e-12):
    stamps, q, qd = motion(50)
    found = samples(path, stated)
    assert found[0] == [stamp - START + first for stamp in stamps]
    np.testing.assert_allclose(found[1], q, rtol=0, atol=tolerance)
    np.testing.assert_allclose(found[2], qd if velocity else np.zeros((50, 0)), atol=tolerance)


def seconds(stamps, since=0):
    """Return stamps in s as text, with all their digits."""
    return [f'{(s - since) // 10**9}.{(s - since) % 10**9:09d}' for s in stamps]


BY_NAME = ['shoulder_1', 'shoulder_10', 'slide']
WAYS = {
    'names': BY_NAME + ['shoulder_1_vel', 'shoulder_10_vel', 'slide_vel'],
    'units': ['shoulder_1 [rad]', 'shoulder_10 [rad]', 'slide [m]', 'shoulder_1_vel [rad / s]',
              'shoulder_10_vel [rad / s]', 'slide_vel [m / s]'],
    'dotted': [f'position.{n}' for n in BY_NAME] + [f'velocity.{n}' for n in BY_NAME],
    'plotjuggler': [f'/joint_states/{n}/{what}' for what in ('position', 'velocity')
                    for n in BY_NAME],
    'from 1': ['q1', 'q2', 'q3', 'qd1', 'qd2', 'qd3'],
    'from 0': ['q0', 'q1', 'q2', 'v0', 'v1', 'v2'],
    'brackets': [f'{what}[{i}]' for what in ('position', 'velocity') for i in range(3)],
    'joint_i_pos': [f'joint_{i}_pos' for i in (1, 2, 3)] + [f'joint_{i}_vel' for i in (1, 2, 3)],
}


@pytest.mark.parametrize('ending', ['.csv', '.csv.gz', '.parquet'])
@pytest.mark.parametrize('way', WAYS)
def test_columns_are_found(way, ending, tmp_path):
    stamps, q, qd = motion(50)
    extra = [f'effort_{i}' for i in (1, 2, 3)] + ['note']
    agree(write(tmp_path / f'x{ending}', ['stamp_ns', *WAYS[way], *extra],
                [stamps, *q.T.tolist(), *qd.T.tolist(), *[[0.0] * 50] * 3, ['x'] * 50]))


@pytest.mark.parametrize('name, values', [
    ('stamp', lambda s: seconds(s)), ('time', lambda s: [x / 1e6 for x in s]),
    ('timestamp', lambda s: [x // 1000 for x in s]), ('t', lambda s: s),
    ('Time [ms]', lambda s: [x / 1e6 for x in s]), ('%time', lambda s: s)])
def test_stamps_since_1970_in_any_unit(name, values, tmp_path):
    stamps, q, _ = motion(50)
    path = write(tmp_path / 'x.csv', [name, *BY_NAME], [values(stamps), *q.T.tolist()])
    found = samples(path)[0]
    exact = name in ('stamp', 't', '%time')
    assert max(abs(a - b) for a, b in zip(found, stamps)) <= (0 if exact else 1000)


@pytest.mark.parametrize('factor', [1e9, 1e6, 1e3, 1])
def test_stamps_without_an_epoch_by_the_rate_they_mean(factor, tmp_path):
    stamps, q, _ = motion(50)
    since = [(stamp - START) / factor for stamp in stamps]
    path = write(tmp_path / 'x.csv', ['t', *BY_NAME], [since, *q.T.tolist()])
    agree(path, velocity=False, first=0)
    agree(path, TableFormat(epoch=START), velocity=False)


def test_seconds_and_nanoseconds_and_dates(tmp_path):
    stamps, q, _ = motion(50)
    agree(write(tmp_path / 'x.csv', ['header.stamp.sec', 'header.stamp.nanosec', *BY_NAME],
                [[s // 10**9 for s in stamps], [s % 10**9 for s in stamps], *q.T.tolist()]),
          velocity=False)
    dates = [str(np.datetime64(s // 1000, 'us')) for s in stamps]
    found = samples(write(tmp_path / 'y.csv', ['time', *BY_NAME], [dates, *q.T.tolist()]))[0]
    assert max(abs(a - b) for a, b in zip(found, stamps)) < 1000


@pytest.mark.parametrize('name', ['time', 'time_s'])
@pytest.mark.parametrize('kind', ['timestamp[ns]', 'timestamp[us]', 'duration[ns]', 'text', 'Z',
                                  '+02:00'])
def test_typed_stamps_are_exact_whatever_the_column_is_called(kind, name, tmp_path):
    """Stamps of ROS are whole ns, which no date of Python holds."""
    stamps, q, _ = motion(50)
    unit, first = (1000, START // 1000 * 1000) if '[us]' in kind else (1, START + 123)
    exact = [stamp - START + first for stamp in stamps]
    column = pyarrow.array(exact).cast(pyarrow.int64())
    if kind == 'text':
        column = [str(np.datetime64(stamp, 'ns')) for stamp in exact]
    elif kind == 'Z':
        column = [str(np.datetime64(stamp, 'ns')) + 'Z' for stamp in exact]
    elif kind == '+02:00':
        column = [str(np.datetime64(stamp + 7200 * 10**9, 'ns')).replace('.', ',') + kind
                  for stamp in exact]
    elif kind == 'duration[ns]':
        column = column.cast(pyarrow.duration('ns'))
    else:
        column = pyarrow.array([s // unit for s in exact]).cast(
            pyarrow.timestamp(kind[10:12], 'Europe/Berlin'))
    path = write(tmp_path / 'x.parquet', [name, *BY_NAME], [column, *q.T.tolist()])
    agree(path, velocity=False, first=first)
    agree(path, TableFormat(time='ms'), velocity=False, first=first)


def test_dates_with_time_zones_here_and_there(tmp_path):
    stamps, q, _ = motion(50)
    dates = [str(np.datetime64(stamp, 'ns')) + 'Z' * (k % 2) for k, stamp in enumerate(stamps)]
    agree(write(tmp_path / 'x.csv', ['t', *BY_NAME], [dates, *q.T.tolist()]), velocity=False)


@pytest.mark.parametrize('name, unit', [('time_us', 10**3), ('stamp_us', 10**3),
                                        ('Timestamp_MS', 10**6), ('t_ns', 1), (' time', 10**9)])
def test_columns_of_stamps_that_name_their_unit(name, unit, tmp_path):
    stamps, q, _ = motion(50)
    agree(write(tmp_path / 'x.csv', ['a', name, *BY_NAME],
                [[0] * 50, [(s - START) // unit if unit < 10**9 else (s - START) / unit
                            for s in stamps], *q.T.tolist()]), velocity=False, first=0)


def test_a_unit_of_stamps_that_cannot_be(tmp_path):
    stamps, q, _ = motion(50)
    path = write(tmp_path / 'x.csv', ['t', *BY_NAME], [stamps, *q.T.tolist()])
    with pytest.raises(ToolError, match='no time in the unit that is stated or named; state it'):
        samples(path, TableFormat(time='s'))


@pytest.mark.parametrize('separator', [',', ' ', ';'])
def test_a_table_that_numpy_has_written(separator, tmp_path):
    stamps, q, _ = motion(50)
    np.savetxt(tmp_path / 'x.txt', np.column_stack([(np.array(stamps) - START) * 1e-9, q]),
               header=separator.join(['t', *BY_NAME]), delimiter=separator)
    agree(tmp_path / 'x.txt', velocity=False, first=0)


def test_rows_that_are_cut_off_are_damage(tmp_path):
    """As of a program that was stopped while it wrote."""
    stamps, q, _ = motion(51)
    path = write(tmp_path / 'x.csv', ['stamp', *BY_NAME], [seconds(stamps), *q.T.tolist()])
    path.write_text(path.read_text()[:-30])
    agree(path, velocity=False)
    table = JointTable(path)
    assert len(list(table.samples(JOINTS))) == 50
    assert table.damage == [f'{path}: rows with more or fewer cells than names: 1, the first is '
                            'row 51']


def test_joints_that_stand_still_at_zero_first(tmp_path):
    """Whole numbers for longer than one reads at once."""
    count = 200_000
    q = [0] * (count - 1)
    path = write(tmp_path / 'x.csv', ['stamp', *BY_NAME],
                 [range(START, START + count * 10**7, 10**7), [*q, 0.25], [*q, ''], q + [1]])
    assert path.stat().st_size > 1 << 22
    assert samples(path)[1][-1].tolist() == pytest.approx([0.25, np.nan, 1], nan_ok=True)


def test_rostopic_echo(tmp_path):
    """Names are in the rows, in the order of the message."""
    stamps, q, qd = motion(50)
    order = [2, 0, 1]
    names = (['%time', 'field.header.seq', 'field.header.stamp', 'field.header.frame_id']
             + [f'field.{what}{i}' for what in ('name', 'position', 'velocity', 'effort')
                for i in range(3)])
    columns = [stamps, range(50), stamps, [''] * 50, *[[BY_NAME[i]] * 50 for i in order],
               *q[:, order].T.tolist(), *qd[:, order].T.tolist(), *[[0.0] * 50] * 3]
    agree(write(tmp_path / 'x.csv', names, columns))


@pytest.mark.parametrize('prefix', ['', 'joint_states.'])
def test_lists_as_messages_have_them(prefix, tmp_path):
    """By the names in them, in whatever order, or by their places; of one length each."""
    stamps, q, qd = motion(50)
    order = [2, 0, 1]

    def table(**columns):
        names = ['stamp', *(f'{prefix}{name}' for name in columns)]
        return write(tmp_path / 'x.parquet', names, [stamps, *columns.values()])

    turned = {'position': q[:, order].tolist(), 'velocity': qd[:, order].tolist()}
    agree(table(name=[[BY_NAME[i] for i in order]] * 50, effort=[[]] * 50, **turned))
    fixed = pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(q.ravel()), 3)
    agree(table(position=fixed, velocity=qd.tolist()))
    with pytest.raises(ToolError, match=r"position' has lists of different lengths \(3, 2\)"):
        samples(table(position=[[0.0] * 3] * 49 + [[0.0] * 2]))


def test_rows_that_nobody_sorted_are_told(tmp_path):
    stamps, q, _ = motion(50)
    rows = np.random.default_rng(0).permutation(50)
    for order, told in ((rows, True), ([*range(25, 50), *range(25)], False)):   # two recordings
        table = JointTable(write(tmp_path / 'x.csv', ['stamp_ns', *BY_NAME], [
            np.array(stamps)[order].tolist(), *q[order].T.tolist()]))
        assert len([*table.samples(JOINTS)]) == 50
        assert ['of 50 rows: sort them by' in line for line in table.damage] == [True] * told


def test_columns_that_are_stated(tmp_path):
    stamps, q, qd = motion(50)
    path = write(tmp_path / 'x.csv', ['when', 'a', 'b', 'c', 'db'],
                 [seconds(stamps), *q.T.tolist(), qd[:, 1].tolist()])
    stated = {'stamp': 'when', 'shoulder_1': 'a', 'shoulder_10': 'b', 'slide': 'c'}
    agree(path, TableFormat(stated), velocity=False)
    with pytest.raises(ParameterError, match="columns slide' is 'z'; allowed: of .*when, a, b"):
        samples(path, TableFormat({**stated, 'slide': 'z'}))


def test_degrees_and_millimetres(tmp_path):
    stamps, q, qd = motion(50)
    factors = [180 / np.pi, 180 / np.pi, 1000]
    columns = [stamps, *(q * factors).T.tolist(), *(qd * factors).T.tolist()]
    path = write(tmp_path / 'x.csv', ['stamp_ns', *WAYS['names']], columns)
    agree(path, TableFormat(angle='deg', length='mm'))
    with pytest.raises(ToolError, match=r'joint shoulder_1 \(revolute\) is at 12.78\d* in row 46; '
                       'what unit is that'):
        samples(path)
    named = ['shoulder_1_deg', 'shoulder_10_deg', 'slide_deg']
    agree(write(tmp_path / 'y.csv', ['stamp_ns', *named],
                [stamps, *(q * [180 / np.pi, 180 / np.pi, 1]).T.tolist()]), velocity=False)


def test_each_column_may_name_its_unit(tmp_path):
    stamps, q, qd = motion(50)
    columns = [stamps, *(q * [180 / np.pi, 180 / np.pi, 1000]).T.tolist()]
    positions = ['shoulder_1_deg', 'shoulder_10 [degrees]', 'slide (mm)']
    agree(write(tmp_path / 'x.csv', ['t', *positions], columns), velocity=False)
    path = write(tmp_path / 'y.csv', [
        't', *positions, 'shoulder_1_vel_rad_s', 'shoulder_10_vel', 'slide_vel [m/s]'],
        [*columns, *(qd * [1, 180 / np.pi, 1]).T.tolist()])
    agree(path)
    # So may velocities where the unit of the positions is stated, but not those another one.
    names = ['t', *BY_NAME, 'shoulder_1_vel_rad_s', 'shoulder_10_vel_rad_s', 'slide_vel [m/s]']
    path = write(tmp_path / 'v.csv', names, [*columns, *qd.T.tolist()])
    agree(path, TableFormat(angle='deg', length='mm'))
    with pytest.raises(ParameterError, match="'units' is 'rad'; allowed: deg, as column "
                                             "'shoulder_1_deg' of .* says"):
        samples(tmp_path / 'y.csv', TableFormat(angle='rad'))
    _, q, _ = motion(50)
    joints = {'deg_1': 'revolute', 'mm': 'prismatic'}
    path = write(tmp_path / 'z.csv', ['t', *joints], [stamps, *q[:, :2].T.tolist()])
    np.testing.assert_array_equal(samples(path, joints=joints)[1], q[:, :2])


def test_what_is_not_finite_is_no_question_of_units(tmp_path):
    stamps, q, _ = motion(50)
    q[3, 0], q[4, 1] = np.inf, np.nan
    path = write(tmp_path / 'x.csv', ['t', *BY_NAME], [stamps, *q.T.tolist()])
    np.testing.assert_array_equal(samples(path)[1], q)


def test_rows_with_one_stamp_are_refused_for_that(tmp_path, capsys):
    """Seconds since 1970 as floats of 32 bits stand still for two minutes."""
    count = 200
    path = write(tmp_path / 'x.csv', ['t', *rec.PUMA.joint_names],
                 [[float(np.float32(START * 1e-9))] * count, *[[0.1] * count] * 6])
    assert bag.main([str(path), '--robot', PUMA, '--time-unit', 's', '--output',
                     str(tmp_path / 'y.csv')]) == 1
    out = capsys.readouterr().out
    assert '199 stamp_not_increasing' in out and '1 implausible_jump' in out


@pytest.mark.parametrize('names, values, message', [
    (['a', *BY_NAME], None, 'no column of stamps; seen: a, shoulder_1, shoulder_10, slide'),
    (['t', 'shoulder_1', 'x', 'slide'], None,
     'no column for the position of shoulder_10; seen: t, shoulder_1, x, slide; name them by '
     '--columns shoulder_10=COLUMN'),
    (['t', 'q1_left', 'q2_left', 'q3'], None, 'no column for the position of shoulder_1'),
    (['t', 'left_q1', 'right_q1', 'slide'], None, 'no column for the position of shoulder_1'),
    (['t', 'pos_shoulder_1', 'shoulder_1_pos', 'slide'], None, 'may be shoulder_1; choose by'),
    (['t', *BY_NAME], lambda k: k * 150.0,
     'begin with 0.0 and advance by 150 a row, which is 10 to '
     '5000 rows a second in no unit; state it by --time-unit s, ms, us, ns'),
    (['t', *BY_NAME], lambda k: 'yesterday', "column 't' is 'yesterday'; allowed: a number or"),
    (['t', *BY_NAME], lambda k: '2026-05-01 08:00' if k < 9 else '', "'t' is ''; allowed: a num"),
    (['t', *BY_NAME], lambda k: 'nan', 'not finite'),
])
def test_what_is_not_clear_is_asked(names, values, message, tmp_path):
    _, q, _ = motion(50)
    stamps = [0.01 * k if values is None else values(k) for k in range(50)]
    path = write(tmp_path / 'x.csv', names, [stamps, *q.T.tolist()])
    with pytest.raises(ToolError, match=message):
        samples(path)


@pytest.mark.parametrize('content', [b'', b'\n', b'\xff\xfe\x00', b't,q1\n', b'PAR1'])
@pytest.mark.parametrize('ending', ['.csv', '.parquet'])
def test_no_table(content, ending, tmp_path, capsys):
    (tmp_path / f'x{ending}').write_bytes(content)
    assert bag.main([str(tmp_path / f'x{ending}'), '--robot', PUMA,
                     '--output', str(tmp_path / 'y.csv')]) == 2
    assert capsys.readouterr().err.count('\n') == 1
    assert not (tmp_path / 'y.csv').exists()


@pytest.mark.parametrize('ending', ['.csv', '.parquet'])
def test_names_that_are_no_utf_8_or_there_twice(ending, tmp_path):
    """The degree sign as Latin-1 has it, and a spreadsheet's column that was copied."""
    stamps, q, _ = motion(50)
    path = write(tmp_path / f'x{ending}', ['t', *BY_NAME], [stamps, *q.T.tolist()])
    whole = path.read_bytes()
    path.write_bytes(whole.replace(b'slide', b'slid\xb0'))
    with pytest.raises(ToolError, match='the names of its columns are not in UTF-8'):
        samples(path)
    names = ['t', 'slide', *BY_NAME]
    if ending == '.csv':
        write(path, names, [stamps, stamps, *q.T.tolist()])
    else:
        parquet.write_table(pyarrow.Table.from_arrays(
            [pyarrow.array(column) for column in [stamps, stamps, *q.T.tolist()]], names), path)
    with pytest.raises(ToolError, match="column 'slide' is there 2 times; rename all but one"):
        samples(path)


def test_a_long_line_of_names_is_read_wherever_it_is_cut(tmp_path):
    stamps, q, _ = motion(50)
    more = [f'\u03c4_{k}' for k in range(14_000)]
    path = write(tmp_path / 'x.csv', ['t', *BY_NAME, 'a', *more],
                 [stamps, *q.T.tolist(), stamps, *[[0] * 50] * len(more)])
    assert samples(path)[0] == stamps


def test_text_among_numbers(tmp_path):
    stamps, q, _ = motion(50)
    columns = [stamps, *q.T.tolist()]
    columns[2][7] = 'off'
    path = write(tmp_path / 'x.csv', ['t', *BY_NAME], columns)
    with pytest.raises(ToolError, match="column 'shoulder_10' holds string values"):
        samples(path)
    columns[2][7] = ''      # an empty cell is a value that was not measured
    assert np.isnan(samples(write(path, ['t', *BY_NAME], columns))[1][7, 1])


def test_a_table_gives_the_states_of_the_bag_it_is_of(tmp_path, capsys):
    given = [rec.TYPES.deserialize_cdr(data, kind) for _, kind, _, data in rec.samples(600)]
    path = write(tmp_path / 'x.csv', ['stamp', *rec.PUMA.joint_names, *[
        f'{name}_velocity' for name in rec.PUMA.joint_names]], [
        seconds(map(rec.stamp_of, given)),
        *np.array([m.position for m in given]).T.tolist(),
        *np.array([m.velocity for m in given]).T.tolist()])
    recorded = rec.write_bag(tmp_path / 'run', rec.samples(600))
    for source, name in ((path, 'table'), (recorded, 'bag')):
        assert bag.main([str(source), '--robot', PUMA, '--output',
                         str(tmp_path / f'{name}.parquet')]) == 0
    table, other = (read_history(tmp_path / f'{name}.parquet', ['accel'])
                    for name in ('table', 'bag'))
    assert table.start == other.start
    np.testing.assert_array_equal(table.values['accel'], other.values['accel'])

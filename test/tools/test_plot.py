# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures: the lines that are drawn are the states, and every file format is written."""
from pathlib import Path
import re

import numpy as np
import pytest

pytest.importorskip('matplotlib').use('agg')
pytest.importorskip('rosbags')

from matplotlib import pyplot    # noqa: E402

from screw_kinematics import Joint, models, SerialChain    # noqa: E402
from screw_kinematics.recordings.history import QUANTITIES    # noqa: E402
from screw_kinematics.recordings.recorded_states import read_bag_histories    # noqa: E402
from screw_kinematics.recordings.recording import Recording    # noqa: E402
from screw_kinematics.tools import robot_options    # noqa: E402
from screw_kinematics.tools.bag import main as bag_tool    # noqa: E402
from screw_kinematics.tools.plot import main as plot    # noqa: E402
from screw_kinematics.tools.plot.figure11 import draw_figure11    # noqa: E402
from screw_kinematics.tools.plot.histories import draw_history, motion_history    # noqa: E402
from screw_kinematics.tools.plot.space import draw_space    # noqa: E402

from support import recordings    # noqa: E402

ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'


@pytest.fixture(autouse=True)
def closed_figures():
    """Close what a test has drawn."""
    yield
    pyplot.close('all')


def test_figure11_begins_with_the_paper_s_values():
    # Found by exact differentiation of the DH product: rad/s, mm/s, mm/s2; then reduced.
    known = [(.110409, .584824, .703910), (128.262094, 144.769510, -130.620410), None,
             (-75.851720, 58.070508, -78.416507, 102.442998, -46.636100, -19.389517)]
    panels = draw_figure11().axes
    assert len(panels) == 4
    for axis, values in zip(panels, known):
        first = [line.get_ydata()[0] for line in axis.lines]
        last = [line.get_ydata()[-1] for line in axis.lines]
        np.testing.assert_allclose(first, last, atol=1e-9)    # one period
        if values is not None:
            np.testing.assert_allclose(first, values, atol=1e-6)


def test_each_drawn_order_is_the_derivative_of_the_one_before():
    robot = models.load(robot_options.PUMA)
    time = np.linspace(0.0, 1.0, 2001)
    figure = draw_history([motion_history(robot, robot_options.motion(robot, 'multisine'), time,
                                          ['pose', 'twist', 'accel', 'jerk', 'snap'])])
    linear = [axis.lines for axis in figure.axes[1::2]]
    for lower, higher in zip(linear, linear[1:]):
        for below, above in zip(lower, higher):
            slope = np.gradient(below.get_ydata(), time, edge_order=2)
            scale = np.abs(above.get_ydata()).max() + 1
            np.testing.assert_allclose(slope[2:-2], above.get_ydata()[2:-2],
                                       atol=2e-4 * scale)


@pytest.mark.parametrize('robot', ['puma560', 'rpr', 'panda'])
def test_screw_axis_in_the_picture_moves_along_itself_only(robot):
    robot = models.load(ROBOTS / f'{robot}.yaml')
    q, qd = robot_options.motion(robot, 'paper').derivatives(1.0, 1)
    space, = draw_space(robot, q, qd).axes
    arrow, = [c for c in space.collections if c.get_label() == 'instantaneous screw axis']
    # The shaft of the arrow: begin and end of the first segment.
    begin, end = np.array(arrow._segments3d[0])
    state = robot.state(q, qd).about(begin)
    np.testing.assert_allclose(np.cross(state.velocity[3:], end - begin), 0, atol=1e-12)
    np.testing.assert_allclose(np.cross(state.velocity[:3], end - begin), 0, atol=1e-12)


@pytest.mark.parametrize('distance', [0.4, 4.0])
def test_a_far_screw_axis_is_drawn_whole(distance):
    """A slide that turns a little: the axis is v / w away, and in the picture."""
    robot = SerialChain([Joint('turn', 'revolute', (0, 0, 1)), Joint('slide', 'prismatic',
                                                                     (1, 0, 0))], np.eye(4))
    space, = draw_space(robot, np.array([0.0, 0.5]), np.array([1.0, distance])).axes
    arrow, = [c for c in space.collections if c.get_label() == 'instantaneous screw axis']
    begin, end = np.array(arrow._segments3d[0])
    # v = (d, 0.5, 0) at (0.5, 0, 0), so the axis is parallel to z through (0, d, 0).
    np.testing.assert_allclose([begin[:2], end[:2]], [[0, distance], [0, distance]], atol=1e-12)
    assert space.get_xlim()[0] <= 0 and 0.5 <= space.get_xlim()[1]
    assert space.get_ylim()[0] <= 0 and distance <= space.get_ylim()[1]
    dashed = [line.get_label() for line in space.lines if 'to the screw' in line.get_label()]
    assert (dashed == ['to the screw axis, 4.03 m from the tip']) == (distance == 4.0)


def test_an_axis_out_of_all_proportion_is_told_of():
    robot = SerialChain([Joint('turn', 'revolute', (0, 0, 1)), Joint('slide', 'prismatic',
                                                                     (1, 0, 0))], np.eye(4))
    space, = draw_space(robot, np.array([0.0, 0.5]), np.array([0.01, 9.0])).axes
    assert 'instantaneous screw axis' not in [c.get_label() for c in space.collections]
    assert 'to the screw axis, 900 m from the tip' in [line.get_label() for line in space.lines]
    assert np.ptp(space.get_xlim()) < 2


def test_recorded_states_name_their_frames_whatever_they_are_kept_in(tmp_path):
    """The bag that the tool bag writes by default, and tables; Parquet keeps the names."""
    bag = recordings.write_bag(tmp_path / 'run', recordings.samples(400))
    titles, drawn = set(), []
    for name in ('states', 'states.parquet'):
        output = str(tmp_path / name)
        assert bag_tool.main([str(bag), '--robot', robot_options.PUMA, '--output', output]) == 0
        assert plot.main(['recorded', output, '--output', f'{output}.png']) == 0
        figure = pyplot.gcf()
        titles.add(figure.get_suptitle())
        drawn.append([line.get_ydata() for axis in figure.axes for line in axis.lines])
    assert titles == {'robot: motion of tool relative to base\n'
                      'axes of base, reference point: origin of tool'}
    np.testing.assert_allclose(*drawn, rtol=1e-12)


@pytest.mark.parametrize('span', [('5', '2'), ('50', '60'), ('nan', '2')])
def test_nothing_is_drawn_of_an_empty_span(span, tmp_path, capsys):
    path = recordings.write_bag(tmp_path / 'run', recordings.samples(200))
    table, picture = tmp_path / 'states.csv', tmp_path / 'picture.png'
    assert bag_tool.main([str(path), '--robot', robot_options.PUMA, '--output', str(table)]) == 0
    assert plot.main(['recorded', str(table), '--from', span[0], '--to', span[1],
                      '--output', str(picture)]) == 2
    assert 'allowed: some of the 0.000 to 0.995 s of states' in capsys.readouterr().err
    assert not picture.exists()


def test_forces_of_legs_are_drawn_along_them():
    stewart = models.load(ROBOTS / 'stewart_6ups.yaml')
    q, qd = robot_options.motion(stewart, 'paper').derivatives(1.0, 1)
    space, = draw_space(stewart, q, qd).axes
    arrows = [np.array(c._segments3d[0]) for c in space.collections if c.get_linestyle()[0][1]]
    legs = stewart.points(stewart.posture(q)).values()
    assert len(arrows) == len(legs) == 6
    for (begin, end), points in zip(arrows, legs):
        for joint in (points[0], points[3]):
            np.testing.assert_allclose(np.cross(end - begin, joint - begin), 0, atol=1e-12)


@pytest.mark.parametrize('metadata', ['', '[1]', 'rosbag2_bagfile_information: x', '\x00'])
def test_states_behind_broken_metadata_and_a_clock_that_was_set_back(metadata, tmp_path):
    """The second half of a bag was published before the first, by its stamps."""
    states = tmp_path / 'states'
    run = recordings.write_bag(tmp_path / 'run', recordings.samples(200))
    assert bag_tool.main([str(run), '--robot', robot_options.PUMA, '--output', str(states)]) == 0
    with Recording(states) as recording:
        messages = [*recording.messages({c.kind for c in recording.connections})]
    turned = recordings.write_bag(tmp_path / 'turned', [
        (m.topic, m.kind, k, m.data) for k, m in enumerate(messages[200:] + messages[:200])])
    (turned / 'metadata.yaml').write_text(metadata)
    one, = read_bag_histories(states, ['twist', 'accel'])
    other, = read_bag_histories(turned, ['twist', 'accel'])
    assert (one.tip_frame, other.tip_frame) == ('tool', 'tip')
    for quantity, values in one.values.items():
        np.testing.assert_array_equal(other.values[quantity], values)


@pytest.mark.parametrize('arguments, told', [
    (['motion', '--duration', 'nan'], "'duration' is nan; allowed: more than 0"),
    (['motion', '--duration', '-1'], "'duration' is -1.0; allowed: more than 0"),
    (['axodes', '--duration', 'inf'], "'duration' is inf; allowed: more than 0"),
    (['motion', '--quantities', ''], "--quantities: got ''; allowed: names with commas"),
    (['screws', '--q', '1,2,a'], "--q: got '1,2,a'; allowed: finite numbers with commas"),
    (['screws', '--q', '1,2,nan'], "--q: got '1,2,nan'; allowed: finite numbers with commas")])
def test_what_cannot_be_drawn_is_told_in_one_line(arguments, told, tmp_path, capsys):
    kind, *options = arguments
    picture = tmp_path / 'picture.png'
    try:
        code = plot.main([kind, str(ROBOTS / 'rpr.yaml'), *options, '--output', str(picture)])
    except SystemExit as end:
        code = end.code
    line, = capsys.readouterr().err.splitlines()
    assert code == 2 and told in line and not picture.exists()


@pytest.mark.parametrize('ending', [*plot.ENDINGS, '.PNG'])
def test_file_formats(tmp_path, ending):
    output = tmp_path / 'folder' / f'picture{ending}'
    assert plot.main(['figure11', '--output', str(output)]) == 0
    head = {'.png': b'\x89PNG', '.svg': b'<?xml', '.pdf': b'%PDF'}[ending.lower()]
    assert output.read_bytes().startswith(head)


@pytest.mark.parametrize('arguments', [
    ['motion', str(ROBOTS / 'panda.yaml'), '--motion', 'minjerk', '--mm', '--quantities',
     ','.join(QUANTITIES)],
    ['screws', str(ROBOTS / 'rpr.yaml'), '--q', '0.5,0.3,-0.2', '--qd', '0,0.1,0'],
    ['screws', str(ROBOTS / 'puma560.yaml'), '--qd', '0,0,0,0,0,0'],
    ['screws', str(ROBOTS / 'delta.yaml'), '--qd', '0,0,0'],
    ['axodes', str(ROBOTS / 'puma560.yaml')],
    ['axodes', str(ROBOTS / 'planar_3rrr.yaml'), '--motion', 'multisine', '--duration', '1'],
])
def test_commands(tmp_path, arguments):
    assert plot.main([*arguments, '--output', str(tmp_path / 'picture.png')]) == 0
    assert (tmp_path / 'picture.png').stat().st_size > 10_000


def test_nothing_is_overwritten_unless_told(tmp_path, capsys):
    output = tmp_path / 'picture.png'
    output.write_text('mine')
    assert plot.main(['figure11', '--output', str(output)]) == 2
    assert 'picture.png exists already; choose another output, or --force' in (
        capsys.readouterr().err)
    assert output.read_text() == 'mine'
    assert plot.main(['figure11', '--output', str(output), '--force']) == 0
    assert output.read_bytes().startswith(b'\x89PNG')


@pytest.mark.parametrize('arguments, message', [
    (['motion', 'no.yaml'], 'no.yaml'),
    (['motion', str(ROBOTS / 'rpr.yaml'), '--quantities', 'speed'], "unknown quantity 'speed'"),
    (['screws', str(ROBOTS / 'rpr.yaml'), '--q', '1,2'], r'q: expected shape \(3,\)'),
    (['recorded', 'states.txt'], 'states.txt: no bag there; allowed: a directory with'),
    (['recorded', 'no.parquet'], 'no.parquet: no such file'),
    (['figure11', '--output', 'figure11.bmp'], "'figure11.bmp'; allowed: .*.svg"),
])
def test_errors_are_one_line_and_exit_code_2(capsys, arguments, message):
    assert plot.main([*arguments, *([] if '--output' in arguments else ['--output', 'x.png'])
                      ]) == 2
    error = capsys.readouterr().err
    assert error.startswith('screw-kinematics plot: ') and error.count('\n') == 1
    assert re.search(message, error)

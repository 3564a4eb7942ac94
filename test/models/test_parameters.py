# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of model files: numbers for the node, symbols for formulas."""
import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ModelError

TEXT = """\
parameters: {a: 250, turn: 90}
units: {length: mm, angle: deg}
joints:
  - {name: q1, axis: [0, 0, 1], point: [-a, 2*a, 0]}
  - {name: a, axis: [0, 0, 1], point: [0.5*a, 0, 1]}
home: {xyz: [a, 0, b], rpy: [0, 0, turn]}
"""


def load(tmp_path, text, **options):
    """Return the robot of a model file's text."""
    file = tmp_path / 'arm.yaml'
    file.write_text(text)
    return models.load(file, **options)


def test_values_are_put_in_in_the_units_of_the_file(tmp_path):
    robot = load(tmp_path, TEXT.replace('b]', '10]'))
    np.testing.assert_allclose([joint.point for joint in robot.joints],
                               [[-0.25, 0.5, 0], [0.125, 0, 0.001]])
    np.testing.assert_allclose(robot.T_base_tool[:3, 3], [0.25, 0, 0.01])
    np.testing.assert_allclose(robot.T_base_tool[:2, :2], [[0, -1], [1, 0]], atol=1e-15)
    assert robot.joint_names == ('q1', 'a')      # a name is no number


def test_lengths_stay_symbols_for_formulas(tmp_path):
    """Without a value too; angles are their values."""
    symbolic = pytest.importorskip('screw_kinematics.symbolic.expressions')
    robot = load(tmp_path, TEXT, symbol=symbolic.parameter)
    a, b = symbolic.parameter('a'), symbolic.parameter('b')
    state = symbolic.symbolic_state(robot, 1)
    assert [joint.point[0].coeff(a) for joint in robot.joints] == [-1, 0.5]
    assert state.pose[2, 3] == b and state.pose[0, 3].has(a)
    numbers = dict(zip(np.ravel(symbolic.joint_symbols(2, 1)), (0.3, -0.4, 1.1, 0.7)))
    expected = load(tmp_path, TEXT.replace('b]', '10]')).state([0.3, -0.4], [1.1, 0.7])
    found = [float(x.subs({a: 0.25, b: 0.01, **numbers})) for x in state.velocity]
    np.testing.assert_allclose(found, expected.velocity, rtol=0, atol=1e-14)


def test_rows_with_symbols_and_rounded_quarter_turns_are_exact(tmp_path):
    symbolic = pytest.importorskip('screw_kinematics.symbolic.expressions')
    robot = load(tmp_path, """
dh: {convention: standard, rows: [{name: s, a: L1}, {name: e, a: L2, alpha: 1.57079632679}]}
tool: {xyz: [0, 0, 2*c]}""", symbol=symbolic.parameter)
    pose = symbolic.symbolic_state(robot, 1).pose
    assert str(pose[0, 3]) == 'L1*cos(q1) + L2*cos(q1 + q2) + 2*c*sin(q1 + q2)'
    assert pose[2].tolist() == [0, 1, 0, 0]


@pytest.mark.parametrize('change, message', [
    (('b]', 'b]'), r"xyz: got .*'b'.*; allowed: 3 finite numbers"),
    (('a: 250', 'a: '), "parameter 'a' has no value; only formulas"),
    (('a: 250', 'a: long'), "parameters: a: got 'long'; allowed: a finite number"),
    (('a: 250', '2a: 250'), "parameters: '2a' is no name"),
    (('{a: 250, turn: 90}', '[a]'), r"parameters: got \['a'\]"),
])
def test_what_is_no_number_is_refused(tmp_path, change, message):
    with pytest.raises(ModelError, match=message):
        load(tmp_path, TEXT.replace(*change))


def test_angles_cannot_be_symbols(tmp_path):
    symbolic = pytest.importorskip('screw_kinematics.symbolic.expressions')
    with pytest.raises(ModelError, match="parameter 'turn' has no value; only lengths can be"):
        load(tmp_path, TEXT.replace('turn: 90', 'turn: '), symbol=symbolic.parameter)

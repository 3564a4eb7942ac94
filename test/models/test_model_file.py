# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Model files: units, poses, DH rows, followed joints, and every refusal."""
import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ModelError


@pytest.fixture
def load(tmp_path):
    def load(text, *frames):
        path = tmp_path / 'arm.yaml'
        path.write_text(text, encoding='utf-8')
        return models.load(path, *frames)
    return load


SCREWS = """
units: {length: mm, angle: deg}
joints:
  - {name: q1, axis: [0, 0, 2], point: [100, 0, 0]}
  - {name: q2, kind: helical, axis: [0, 1, 0], point: [1, 2, 3], pitch: 36}
  - {name: q3, kind: prismatic, axis: [1, 0, 0]}
home: {xyz: [1, 2, 3], rpy: [0, 0, 90]}
"""


def test_screws_in_millimetres_and_degrees(load):
    chain = load(SCREWS)
    assert (chain.name, chain.base_frame, chain.tip_frame) == ('arm', 'base', 'tool')
    assert [j.kind for j in chain.joints] == ['revolute', 'helical', 'prismatic']
    np.testing.assert_allclose(chain.joints[0].axis, [0, 0, 1])
    np.testing.assert_allclose(chain.joints[0].point, [0.1, 0, 0])
    # 36 mm a degree are 36 * 360 mm a turn.
    np.testing.assert_allclose(2 * np.pi * chain.joints[1].pitch, 0.036 * 360)
    np.testing.assert_allclose(
        chain.T_base_tool, [[0, -1, 0, .001], [1, 0, 0, .002], [0, 0, 1, .003], [0, 0, 0, 1]])


@pytest.mark.parametrize('unit, metres', [('m', 1), ('cm', .01), ('mm', .001), ('in', .0254)])
def test_length_units(load, unit, metres):
    text = (f'units: {{length: {unit}}}\njoints: [{{name: q, axis: [1, 0, 0]}}]\n'
            'home: {xyz: [431.8, 0, 0]}')
    assert load(text).T_base_tool[0, 3] == pytest.approx(431.8 * metres, rel=1e-15)


def test_a_matrix_is_a_pose(load):
    text = SCREWS.replace(
        '{xyz: [1, 2, 3], rpy: [0, 0, 90]}',
        '{matrix: [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]}')
    np.testing.assert_allclose(load(text).T_base_tool, load(SCREWS).T_base_tool, atol=1e-16)


def test_velocity_limits_are_in_the_files_units_per_second(load):
    text = SCREWS.replace('kind: helical', 'kind: helical, velocity_limit: 180').replace(
        'kind: prismatic', 'kind: prismatic, velocity_limit: 250')
    np.testing.assert_allclose(load(text).velocity_limits, [np.inf, np.pi, 0.25], rtol=1e-15)
    with pytest.raises(ModelError, match="'q3': velocity_limit: got -1.*allowed: a positive"):
        load(text.replace('limit: 250', 'limit: -1'))


def test_frames_may_be_named_by_file_or_caller(load):
    assert load('base_frame: b\n' + SCREWS).base_frame == 'b'
    assert load('base_frame: b\n' + SCREWS, 'b', 't').tip_frame == 't'
    with pytest.raises(ModelError, match="arm.yaml: tip_frame: got 'x'; allowed: 't', as the"):
        load('tip_frame: t\n' + SCREWS, None, 'x')


def test_scalars_are_what_they_look_like(load):
    """YAML 1.1 takes ``on`` for a truth value, 1e-3 for text and 010 for eight."""
    text = ('joints: [{name: on, axis: [010, 0, 0], point: [1e-3, +.5, 0x]}]'
            '\nhome: {}').replace('0x', '0')
    joint = load(text).joints[0]
    assert joint.name == 'on' and joint.point.tolist() == [0.001, 0.5, 0]


def dh_frames(convention, rows, q):
    """Multiply the four elementary displacements of each row, as the textbooks do."""
    def about(i, j, angle):
        T = np.eye(4)
        T[i, i] = T[j, j] = np.cos(angle)
        T[j, i], T[i, j] = np.sin(angle), -np.sin(angle)
        return T

    def along(i, length):
        T = np.eye(4)
        T[i, 3] = length
        return T

    T = np.eye(4)
    for (kind, a, alpha, d, theta, pitch), value in zip(rows, q):
        turn = 0 if kind == 'prismatic' else value
        slide = {'prismatic': value, 'helical': pitch * value}.get(kind, 0)
        joint = about(0, 1, theta + turn) @ along(2, d + slide)
        link = along(0, a) @ about(1, 2, alpha)
        T = T @ (joint @ link if convention == 'standard' else link @ joint)
    return T


@pytest.mark.parametrize('convention', ['standard', 'modified'])
@pytest.mark.parametrize('seed', range(4))
def test_dh_rows_are_the_textbook_products(load, convention, seed):
    rng = np.random.default_rng(seed)
    kinds = rng.choice(['revolute', 'prismatic', 'helical', 'continuous'], 6)
    rows = [(kind, *rng.normal(size=4), rng.normal() if kind == 'helical' else 0.0)
            for kind in kinds]
    lines = [f'{{name: j{i}, kind: {kind}, a: {a}, alpha: {alpha}, d: {d}, theta: {theta}, '
             f'pitch: {pitch}}}' for i, (kind, a, alpha, d, theta, pitch) in enumerate(rows)]
    chain = load(f'dh: {{convention: {convention}, rows: [{", ".join(lines)}]}}\n'
                 'base: {xyz: [1, 2, 3], rpy: [0.1, 0.2, 0.3]}\ntool: {xyz: [0, 0, 0.5]}')
    still = load(f'dh: {{convention: {convention}, rows: [{", ".join(lines)}]}}')
    base, tool = np.eye(4), np.eye(4)
    c, s = np.cos([.1, .2, .3]), np.sin([.1, .2, .3])
    base[:3, :3] = (np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
                    @ np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
                    @ np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]]))
    base[:3, 3], tool[2, 3] = [1, 2, 3], 0.5
    for q in rng.normal(size=(5, 6)):
        expected = dh_frames(convention, rows, q)
        scale = {'rtol': 0, 'atol': 1e-12 * abs(expected).max()}
        np.testing.assert_allclose(still.pose(q), expected, **scale)
        np.testing.assert_allclose(chain.pose(q), base @ expected @ tool, **scale)


def test_followers_of_followers_follow_the_measured_joint(load):
    chain = load("""
units: {length: mm, angle: deg}
joints:
  - {name: a, axis: [0, 0, 1], mimic: {joint: b, multiplier: 2, offset: 180}}
  - {name: b, axis: [0, 0, 1], mimic: {joint: elsewhere, multiplier: -1}}
  - {name: c, kind: prismatic, axis: [0, 0, 1], mimic: {joint: elsewhere, offset: 5}}
home: {}
""")
    assert chain.joint_names == ('elsewhere',)
    np.testing.assert_allclose(chain.joint_values([0.1]), [np.pi - 0.2, -0.1, 0.105])


ONE = 'joints: [{name: q, axis: [0, 0, 1]}]\nhome: {}\n'
ROW = 'dh: {convention: standard, rows: [{name: q, a: 1}]}\n'
REFUSED = {
    'empty': ('', 'got None; allowed: keys with values'),
    'a list': ('[1, 2]', 'got .* allowed: keys with values'),
    'no YAML': ('a: [', 'line 1: .*'),
    'tab': ('a:\n\t- b', 'line 2: found character .* that cannot start any token'),
    'not text': ('a: \x07', 'not YAML: .*special characters are not allowed'),
    'tag': ('name: !!python/object:os.system x', "line 1: tag 'tag:yaml.org,2002:python/obj"),
    'alias': ('a: &x [1]\nb: *x', r'line 2: alias \*x; allowed: values written out'),
    'double key': (ONE + 'home: {}', "line 3: key 'home' is given twice"),
    'odd key': ('{[a]: 1}', 'line 1: key that is a collection; allowed: text'),
    'deep': ('[' * 40 + ']' * 40, 'line 1: nested deeper than 20'),
    'too large': ('#' * 50_001, 'more than 50000 bytes'),
    'two documents': ('--- a\n--- b', 'line 2: but found another document'),
    'unknown key': (ONE + 'tipframe: x', "unknown key 'tipframe'; allowed: 'name', 'units', "
                    "'base_frame', 'tip_frame', 'joints', 'home'"),
    'screws and rows': (ONE + ROW, "unknown key 'joints'; allowed: .*'dh', 'base', 'tool'"),
    'unknown unit': (ONE + 'units: {length: furlong}',
                     "units: length: got 'furlong'; allowed: 'm', 'cm', 'mm', 'in'"),
    'unknown units key': (ONE + 'units: {time: s}', "units: unknown key 'time'; allowed: 'len"),
    'units as text': (ONE + 'units: mm', "units: got 'mm'; allowed: keys with values"),
    'no joints': ('joints: []\nhome: {}', r'joints: got \[\]; allowed: a list of 1 to 1000'),
    'joints as text': ('joints: q1\nhome: {}', "joints: got 'q1'; allowed: a list"),
    'no home': ('joints: [{name: q, axis: [0, 0, 1]}]', 'home: got None; allowed: keys'),
    'joint as text': ('joints: [q1]\nhome: {}', "joint 1: got 'q1'; allowed: keys"),
    'nameless': ('joints: [{axis: [0, 0, 1]}]\nhome: {}', 'joint 1: name: got None; allowed: t'),
    'name with NUL': ('joints: [{name: "q\\0", axis: [0, 0, 1]}]\nhome: {}',
                      'name: got .*; allowed: text of 1 to 200 printable characters'),
    'name that is no UTF-8': (ONE + 'tip_frame: "\\ud800"', 'tip_frame: got .*printable'),
    'double name': (ONE.replace('[{', '[{name: q, axis: [1, 0, 0]}, {'),
                    "joint 'q' occurs more than once"),
    'no axis': ('joints: [{name: q}]\nhome: {}', "joint 'q': axis: got None; allowed: 3 fin"),
    'axis of two': (ONE.replace('0, 0, 1', '0, 1'), "joint 'q': axis: got .*; allowed: 3 finit"),
    'axis of words': (ONE.replace('0, 0, 1', '0, 0, up'), "joint 'q': axis: got .*'up'"),
    'zero axis': (ONE.replace('0, 0, 1', '0, 0, 0'), "joint 'q': axis must not be zero"),
    'nan': (ONE.replace('0, 0, 1', '0, 0, .nan'), "joint 'q': axis: got .*'.nan'"),
    'nan in Python': (ONE.replace('0, 0, 1', '0, 0, nan'), "joint 'q': axis: got .*'nan'"),
    'unknown joint key': (ONE.replace('axis', 'axes'), "joint 'q': unknown key 'axes'; allowed"),
    'DH key in a screw': (ONE.replace('axis', 'a: 1, axis'), "joint 'q': unknown key 'a'"),
    'unknown kind': (ONE.replace('axis', 'kind: ball, axis'),
                     "joint 'q': kind: got 'ball'; allowed: 'revolute', 'continuous', 'prism"),
    'helical without pitch': (ONE.replace('axis', 'kind: helical, axis'),
                              "joint 'q': pitch: got None; allowed: a finite number"),
    'pitch of a hinge': (ONE.replace('axis', 'pitch: 1, axis'),
                         "joint 'q': pitch 1.0 needs the kind 'helical', got 'revolute'"),
    'skewed matrix': (ONE.replace('{}', '{matrix: [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], '
                                        '[0, 0, 0, 1]]}'), 'no rigid displacement'),
    'matrix of three': (ONE.replace('{}', '{matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}'),
                        'home: got .*; allowed: xyz and rpy, or a matrix of four rows'),
    'short row': (ONE.replace('{}', '{matrix: [[1, 0, 0, 0], [0, 1], [0, 0, 1, 0], [0]]}'),
                  r"home: matrix: row 2: got \['0', '1'\]; allowed: 4 finite numbers"),
    'matrix and xyz': (ONE.replace('{}', '{xyz: [0, 0, 0], matrix: [a, b, c, d]}'),
                       'home: got .*; allowed: xyz and rpy, or a matrix'),
    'unknown pose key': (ONE.replace('{}', '{quat: 1}'), "home: unknown key 'quat'; allowed: 'x"),
    'mimic as text': (ONE.replace('axis', 'mimic: q2, axis'), "joint 'q': mimic: got 'q2'"),
    'mimic of none': (ONE.replace('axis', 'mimic: {offset: 1}, axis'),
                      "joint 'q': mimic: joint: got None"),
    'mimic of itself': (ONE.replace('axis', 'mimic: {joint: q}, axis'),
                        "joint 'q': mimic: got 'q', 'q'; allowed: .*no circle"),
    'unknown convention': (ROW.replace('standard', 'craig'),
                           "dh: convention: got 'craig'; allowed: 'standard', 'modified'"),
    'no convention': ('dh: {rows: [{name: q}]}', 'dh: convention: got None'),
    'dh as a list': ('dh: [1]', 'dh: got .*; allowed: keys with values'),
    'no rows': ('dh: {convention: modified}', 'dh: rows: got None; allowed: a list of 1 to'),
    'screw key in a row': (ROW.replace('a:', 'axis:'), "joint 'q': unknown key 'axis'; allowed: "
                           "'name', 'kind', 'pitch', 'mimic', 'velocity_limit', 'a', 'alpha', "
                           "'d', 'theta'"),
    'row of words': (ROW.replace('1', 'long'), "joint 'q': a: got 'long'; allowed: a finite n"),
    'overflow': (ROW.replace('1', '1e308').replace('}]', '}, {name: r, a: 1e308}]'),
                 'no rigid displacement|must be finite'),
}


@pytest.mark.parametrize('what', REFUSED)
def test_is_refused(load, what):
    text, message = REFUSED[what]
    with pytest.raises(ModelError, match='arm.yaml: .*' + message) as caught:
        load(text)
    assert len(str(caught.value)) < 2000

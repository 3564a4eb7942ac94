# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""URDF: what is read, and what is refused with which words."""
import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ModelError, ScrewKinematicsError
from support.urdf import joint, robot

TWO = robot('a b c', joint('j', 'a', 'b'), joint('k', 'b', 'c', 'prismatic'))


def test_defaults_are_the_root_and_the_only_leaf():
    chain = models.load_urdf(TWO)
    assert (chain.base_frame, chain.tip_frame, chain.name) == ('a', 'c', 'r')
    assert [j.kind for j in chain.joints] == ['revolute', 'prismatic']


def test_the_only_leaf_is_looked_for_below_the_base():
    text = robot('a b c d', joint('j', 'a', 'b'), joint('k', 'b', 'c'), joint('l', 'a', 'd'))
    assert models.load_urdf(text, base_frame='b').tip_frame == 'c'


def test_axis_is_normalised_and_defaults_to_x():
    text = robot('a b c', joint('j', 'a', 'b', parts='<axis xyz="0 -3e-200 4e-200"/>'),
                 joint('k', 'b', 'c', parts=''))
    first, second = models.load_urdf(text).joints
    np.testing.assert_allclose(first.axis, [0, -0.6, 0.8], rtol=1e-15)
    assert second.axis.tolist() == [1, 0, 0]


def test_continuous_joints_stay_continuous():
    assert models.load_urdf(robot('a b', joint('j', 'a', 'b', 'continuous'))
                            ).joints[0].kind == 'continuous'


def test_quarter_turns_are_exact():
    """A file's pi / 2 leaves no 6e-17 behind, however many follow each other."""
    text = robot('a b c d', *(
        joint(f'{p}{c}', p, c, parts='<origin xyz="0.1 0 0" rpy="1.5707963267948966 '
              '-1.5707963267948966 3.141592653589793"/>') for p, c in ('ab', 'bc', 'cd')))
    chain = models.load_urdf(text)
    for value in (*chain.T_base_tool[:3, :3].ravel(), *np.ravel([j.axis for j in chain.joints])):
        assert value in (-1, 0, 1)


def test_reversing_the_path_inverts_the_motion():
    """Base seen from tip is the inverse of tip seen from base, joint by joint."""
    there, back = models.load_urdf(TWO, 'a', 'c'), models.load_urdf(TWO, 'c', 'a')
    assert [j.name for j in back.joints] == ['k', 'j']
    np.testing.assert_allclose(
        there.pose([0.3, 0.7]) @ back.pose([0.7, 0.3]), np.eye(4), atol=1e-15)


def test_followers_of_followers_follow_the_measured_joint():
    text = robot(
        'a b c d e', joint('source', 'a', 'b'),
        joint('j', 'a', 'c', parts='<mimic joint="source" multiplier="2" offset="0.5"/>'),
        joint('k', 'c', 'd', parts='<mimic joint="j" multiplier="-3" offset="0.25"/>'),
        joint('l', 'd', 'e', parts='<mimic joint="source"/>'))
    chain = models.load_urdf(text, tip_frame='e')
    assert chain.joint_names == ('source',)
    np.testing.assert_allclose(chain.joint_values([0.1]), [0.7, -3 * 0.7 + 0.25, 0.1])
    np.testing.assert_allclose(chain.joint_values([1.0], order=1), [2, -6, 1])


def test_a_measured_joint_outside_the_chain_keeps_its_kind_and_limit():
    """Its followers move differently, and have limits of their own."""
    text = robot(
        'a b c d', joint('motor', 'a', 'b', 'continuous',
                         '<axis xyz="0 0 1"/><limit effort="1" velocity="2.5"/>'),
        joint('j', 'a', 'c', 'prismatic', '<mimic joint="motor"/><limit velocity="0.1"/>'),
        joint('k', 'c', 'd', 'prismatic', '<mimic joint="motor" multiplier="-1"/>'))
    chain = models.load_urdf(text, tip_frame='d')
    assert chain.joint_names == ('motor',)
    assert chain.joint_kinds == ('continuous',)
    assert chain.velocity_limits.tolist() == [2.5]
    assert chain.prismatic.tolist() == [False]


@pytest.mark.parametrize('limit, expected', [
    ('<limit velocity="2.175"/>', 2.175), ('<limit effort="87"/>', np.inf), ('', np.inf),
    ('<limit velocity="0"/>', np.inf), ('<limit velocity="-1"/>', np.inf),
    ('<limit velocity="fast"/>', np.inf), ('<limit velocity="nan"/>', np.inf)])
def test_velocity_limits_are_known_where_stated(limit, expected):
    text = robot('a b', joint('j', 'a', 'b', parts='<axis xyz="0 0 1"/>' + limit))
    assert models.load_urdf(text).velocity_limits.tolist() == [expected]


def test_known_tags_are_passed_over_in_silence():
    text = robot('a b', joint('j', 'a', 'b'), '<gazebo><link name="a"/></gazebo>',
                 '<transmission name="t"><joint name="j"/></transmission>',
                 '<ros2_control name="x" type="system"><joint name="j"/></ros2_control>')
    assert models.load_urdf(text).joint_names == ('j',)
    assert models.load_urdf(text).warnings == ()


@pytest.mark.parametrize('element, kind', [
    ('<xacro:sensor_d435 parent="b"/>', 'macro'), ('<xacro:property name="x"/>', 'macro'),
    ('<lidar><child/></lidar>', 'unknown'), ('<x:include file="y"/>', 'macro')])
def test_what_is_left_beside_sound_joints_is_a_warning_with_its_place(element, kind):
    text = robot('a b', joint('j', 'a', 'b')).replace(
        '<link name="a"/>', f'<link name="a"/>\n\n{element}').replace(
            'name="r"', 'name="r" xmlns:x="http://www.ros.org/wiki/xacro"', 1)
    warning, = models.load_urdf(text).warnings
    assert warning.startswith(f'line 3: the {kind} element {element[1:].split()[0][:5]!r}'[:-1])


@pytest.mark.parametrize('part, warnings', [
    ('<dynamics damping="1"/><safety_controller k_velocity="1"/><hardwareInterface/>', 0),
    ('<backlash value="0.1"/>', 1)])
def test_unknown_parts_of_joints_are_a_warning(part, warnings):
    chain = models.load_urdf(robot('a b', joint('j', 'a', 'b', parts=part)))
    assert chain.dof == 1 and len(chain.warnings) == warnings
    assert all("unknown element 'backlash'" in warning for warning in chain.warnings)


def test_macros_in_links_are_no_matter():
    text = robot('a b', joint('j', 'a', 'b')).replace(
        '<link name="b"/>', '<link name="b"><xacro:insert_block name="inertia"/></link>')
    chain = models.load_urdf(text)
    assert chain.dof == 1 and 'insert_block' in chain.warnings[0]


@pytest.mark.parametrize('tag, meant', [
    ('orgin', 'origin'), ('Origin', 'origin'), ('origins', 'origin'), ('axes', 'axis'),
    ('axsi', 'axis'), ('mimick', 'mimic'), ('parents', 'parent')])
def test_a_misspelt_part_of_a_joint_is_refused(tag, meant):
    text = robot('a b', joint('k', 'a', 'b', parts=f'<{tag} xyz="0 0 1"/>'))
    with pytest.raises(ModelError, match=f"joint 'k': .*{tag}.*did you mean '{meant}'"):
        models.load_urdf(text)


@pytest.mark.parametrize('parts, named', [
    ('<xacro:if value="$(arg mirror)"><axis xyz="0 0 -1"/></xacro:if>', "line 2: .*'xacro:if'"),
    ('<xacro:insert_block name="origin"/><axis xyz="0 0 1"/>', "line 2: .*'xacro:insert_block'"),
    ('<insert_block name="origin"/><axis xyz="0 0 1"/>', "line 2: .*'insert_block'"),
    ('<origin xyz="0 0 1"><xacro:x/></origin>', "line 2: .*'xacro:x'"),
    ('<drake:mimic joint="j"/>', "line 2: got the element 'drake:mimic', which may change"),
    ('<pose>0 0 1 0 0 0</pose>', "line 2: got the element 'pose'"),
    ('<drake:screw_thread_pitch value="1"/>', "line 2: .*'drake:screw_thread_pitch'"),
    ('<origin xyz="${l} 0 0"/>', r"xyz: got '\$\{l\} 0 0', which no macro"),
    ('<parent link="$(arg p)a"/><origin xyz="1 0 0" rpy="0 0 ${pi}"/>', 'rpy: got .*no macro')])
def test_what_is_left_in_a_joint_of_the_chain_is_refused(parts, named):
    """Nobody knows what it would do to the geometry; elsewhere it does nothing."""
    text = robot('a b c', joint('j', 'a', 'b'), '\n', joint('k', 'a', 'c', parts=parts))
    with pytest.raises(ModelError, match=f"joint 'k': .*{named}.*expanded by xacro"):
        models.load_urdf(text, tip_frame='c')
    assert models.load_urdf(text, tip_frame='b').joint_names == ('j',)


def test_links_inside_macros_are_missed_where_they_count():
    """The only leaf may be one no longer; with both frames given the chain is whole."""
    text = robot('a b', joint('j', 'a', 'b'), '<xacro:unless value="0"><link name="c"/>'
                 + joint('k', 'b', 'c') + '</xacro:unless>')
    with pytest.raises(ModelError, match="'xacro:unless' with links or joints in it; allowed"):
        models.load_urdf(text)
    assert models.load_urdf(text, 'a', 'b').joint_names == ('j',)
    with pytest.raises(ModelError, match="tip frame: got 'c'; .*element 'xacro:unless'"):
        models.load_urdf(text, 'a', 'c')


def test_joints_of_other_dialects_are_named_where_they_are_missed():
    text = robot('a b', '<drake:joint name="j" type="screw"><parent link="a"/><child link="b"/>'
                 '<axis xyz="0 0 1"/></drake:joint>')
    with pytest.raises(ModelError, match="several root links.*unknown element 'drake:joint'"):
        models.load_urdf(text)


HALF = 0.7071067811865476


@pytest.mark.parametrize('quaternion, axis', [
    ('0 0 0.70710678 0.70710678', [0, 1, 0]), ('0 0 0 1', [1, 0, 0]), ('0 0 1 0', [-1, 0, 0]),
    ('0 -0.7071 0 0.7071', [0, 0, 1]), (f'0 0 -{HALF} {HALF}', [0, -1, 0])])
@pytest.mark.parametrize('version', ['1.1', '1.2', '1.10'])
def test_quaternions_are_read_from_version_1_1_on(quaternion, axis, version):
    """The axis x, turned; quarter turns are exact, as those of rpy."""
    origin = f'<origin xyz="1 2 3" quat_xyzw="{quaternion}"/><axis xyz="1 0 0"/>'
    text = robot('a b', joint('j', 'a', 'b', parts=origin))
    found, = models.load_urdf(text.replace('<robot', f'<robot version="{version}"')).joints
    assert found.axis.tolist() == axis
    assert found.point.tolist() == [1, 2, 3]


@pytest.mark.parametrize('version, origin, message', [
    ('1.0', 'quat_xyzw="0 0 0 1"', r'quat_xyzw needs <robot version="1.1">, this one has .1\.0'),
    ('', 'quat_xyzw="0 0 0 1"', 'quat_xyzw needs <robot version="1.1">, this one has'),
    ('new', 'quat_xyzw="0 0 0 1"', "quat_xyzw needs .*has 'new'"),
    ('1.1', 'quat_xyzw="0 0 0 1" rpy="0 0 0"', 'rpy or quat_xyzw, not both'),
    ('1.1', 'quat_xyzw="0 0 0 0"', 'a quaternion of length 1'),
    ('1.1', 'quat_xyzw="0 0 1 1"', 'a quaternion of length 1'),
    ('1.1', 'quat_xyzw="0 0 1"', '4 finite numbers'),
    ('1.1', 'quat="0 0 0 1"', "unknown key 'quat'; allowed: 'xyz', 'rpy', 'quat_xyzw'"),
    ('1.0', 'ryp="0 0 1"', "unknown key 'ryp'"), ('1.0', 'rpy="90" degrees="1"', 'unknown key')])
def test_no_attribute_of_an_origin_is_passed_over(version, origin, message):
    text = robot('a b', joint('j', 'a', 'b', parts=f'<origin {origin}/>')).replace(
        '<robot', f'<robot version="{version}"' if version else '<robot')
    with pytest.raises(ModelError, match=f"joint 'j': origin: .*{message}"):
        models.load_urdf(text)


def test_no_attribute_of_an_axis_is_passed_over():
    """But for the zeros that some exporters write."""
    text = robot('a b', joint('j', 'a', 'b', parts='<axis xyz="0 0 1" rpy="0 0 0"/>'))
    assert models.load_urdf(text).joints[0].axis.tolist() == [0, 0, 1]
    with pytest.raises(ModelError, match="joint 'j': axis: rpy: got '0 1 0'; allowed: xyz only"):
        models.load_urdf(text.replace('0 0 0', '0 1 0'))


@pytest.mark.parametrize('leaves, tip', [
    ('base tool0 ft_frame', 'tool0'), ('left_tool0 camera', 'left_tool0'),
    ('left_tool0 right_tool0', None), ('panda_hand_tcp left_finger', None)])
def test_of_several_leaves_only_one_tool0_is_taken(leaves, tip):
    text = robot(f'a b {leaves}', joint('j', 'a', 'b'), *(
        joint(f'to_{leaf}', 'b', leaf, 'fixed') for leaf in leaves.split()))
    if tip is None:
        first = leaves.split()[0]
        with pytest.raises(ModelError, match=f"several leaf links.*; likely '{first}'"):
            models.load_urdf(text)
    else:
        chain = models.load_urdf(text)
        assert chain.tip_frame == tip
        assert chain.warnings[0].startswith(f"tip frame: '{tip}' is taken, of the leaf links")


def test_a_flange_that_holds_a_gripper_is_proposed():
    text = robot('a tool0 left right', joint('j', 'a', 'tool0'), *(
        joint(f'to_{leaf}', 'tool0', leaf, 'fixed') for leaf in ('left', 'right')))
    with pytest.raises(ModelError, match="below it: 'left', 'right'; likely 'tool0'"):
        models.load_urdf(text)
    with pytest.raises(ModelError, match="below it: 'left', 'right'$"):     # it is the base
        models.load_urdf(text, base_frame='tool0')


def test_the_flange_of_another_arm_is_not_proposed():
    text = robot('top a l_tool0 x y r_tool0', *(joint(f'to_{b}', a, b) for a, b in (
        ('top', 'a'), ('a', 'l_tool0'), ('l_tool0', 'x'), ('l_tool0', 'y'), ('top', 'r_tool0'))))
    with pytest.raises(ModelError, match="below it: 'x', 'y'; likely 'l_tool0'$"):
        models.load_urdf(text, base_frame='a')


LONG = robot('base ' + ' '.join(f'link_{i:02d}' for i in range(40)) + ' flange',
             *(joint(f'joint_{i:02d}', 'base' if i == 0 else f'link_{i - 1:02d}',
                     'flange' if i == 40 else f'link_{i:02d}') for i in range(41)))


@pytest.mark.parametrize('given, message', [
    ('flang', r"got 'flang'; did you mean 'flange'\? allowed: a link \('flange', 'base'"),
    ('Flange', r"did you mean 'flange'\? allowed: a link \('flange'"),
    ('left_flange', r"did you mean 'flange'\?"), ('link_7', r"allowed: a link \('link_07', "),
    ('joint_40', r"'joint_40', a joint; did you mean its child link 'flange'\? .*\('flange', "),
    ('?', r"got '\?'; allowed: a link \('base', .* and 30 more")])
def test_the_nearest_names_come_first(given, message):
    with pytest.raises(ModelError, match='tip frame: .*' + message):
        models.load_urdf(LONG, tip_frame=given)


@pytest.mark.parametrize('kind', ['floating', 'planar'])
def test_a_free_joint_above_an_arm_says_which_base_does_without_it(kind):
    text = robot('world base tip', joint('free', 'world', 'base', kind), joint('j', 'base', 'tip'))
    with pytest.raises(ModelError, match=f"'free': type: got '{kind}'.*child link 'base'"):
        models.load_urdf(text)
    assert models.load_urdf(text, 'base').joint_names == ('j',)


def test_the_first_of_repeated_parts_holds():
    """As other readers of URDF have it; but it is told."""
    text = robot('a b', joint('j', 'a', 'b', parts='<axis xyz="0 1 0"/><axis xyz="1 0 0"/>'))
    chain = models.load_urdf(text)
    assert chain.joints[0].axis.tolist() == [0, 1, 0]
    assert ["'axis (a second one)' is passed over" in told for told in chain.warnings] == [True]


def test_lines_of_followers_are_bounded():
    def line(count):
        return robot(' '.join(f'l{i}' for i in range(count + 2)),
                     *(joint(f'j{i}', 'l0', f'l{i + 1}', parts=f'<mimic joint="j{i + 1}"/>')
                       for i in range(count)), joint(f'j{count}', 'l0', f'l{count + 1}'))
    assert models.load_urdf(line(50), tip_frame='l1').joint_names == ('j50',)
    with pytest.raises(ModelError, match="joint 'j0': mimic: got .*; allowed: a line of at most"):
        models.load_urdf(line(51), tip_frame='l1')


def test_a_defect_elsewhere_does_not_stop_an_arm():
    text = robot('a b c', joint('j', 'a', 'b'),
                 joint('k', 'a', 'c', 'floating', '<axis xyz="?"/>'))
    assert models.load_urdf(text, tip_frame='b').joint_names == ('j',)
    with pytest.raises(ModelError, match="joint 'k': type: got 'floating'"):
        models.load_urdf(text, tip_frame='c')


REFUSED = {
    'no XML': ('oops', 'arm.urdf: not well-formed XML: .*line 1'),
    'empty': ('', 'not well-formed XML: no element found'),
    'no robot': ('<sdf/>', "line 1: root element: got 'sdf'; allowed: 'robot'"),
    'no links': ('<robot/>', 'no links; allowed: at least two links'),
    'macros': ('<robot>\n<xacro:include filename="x"/></robot>',
               "line 2: got the macro element 'xacro:include'; allowed: URDF expanded"),
    'bomb': ('<!DOCTYPE r [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]><robot>&b;</robot>',
             "document type 'r'; allowed: none"),
    'external entity': ('<!DOCTYPE r SYSTEM "file:///etc/passwd"><robot/>',
                        "document type 'r'; allowed: none"),
    'undefined entity': ('<robot>&x;</robot>', 'not well-formed XML: undefined entity'),
    'deep': ('<robot>' + '<a>' * 100, 'nested deeper than 50'),
    'lone surrogate': ('<robot name="\udc80"/>', 'line 1: .*surrogates'),
    'nameless link': ('<robot><link/></robot>', 'link 1 of the document: name: got None'),
    'nameless joint': (robot('a b', joint('', 'a', 'b')), 'joint 1 of the document: name: got'),
    'long name': (robot('a', joint('x' * 300, 'a', 'b')),
                  'name: got .*; allowed: text of 1 to 200'),
    'no parent': (robot('a b', '<joint name="j" type="fixed"><child link="b"/></joint>'),
                  "joint 'j': parent: link: got None"),
    'unknown parent': (robot('a b', joint('j', 'z', 'b')),
                       r"joint 'j': parent: got 'z'; allowed: a link \('a', 'b'\)"),
    'double link': (robot('a a'), "link 'a' is defined twice"),
    'double joint': (robot('a b c', joint('j', 'a', 'b'), joint('j', 'b', 'c')),
                     "joint 'j' is defined twice"),
    'two parents': (robot('a b c', joint('j', 'a', 'c'), joint('k', 'b', 'c')),
                    "link 'c' is the child of two joints, 'j' and 'k'"),
    'two roots': (robot('a b c d', joint('j', 'a', 'b'), joint('k', 'c', 'd')),
                  "several root links: 'a', 'c'; allowed: one"),
    'circle only': (robot('a b', joint('j', 'a', 'b'), joint('k', 'b', 'a')),
                    "joints form a cycle through links 'a', 'b'"),
    'circle apart': (robot('r a b', joint('j', 'a', 'b'), joint('k', 'b', 'a')),
                     "joints form a cycle through links 'a', 'b'"),
    'own child': (robot('r a', joint('j', 'a', 'a')), "cycle through links 'a'"),
    'several leaves': (robot('a b c', joint('j', 'a', 'b'), joint('k', 'a', 'c')),
                       "tip frame is needed, .* several leaf links below it: 'b', 'c'"),
    'all fixed': (robot('a b', joint('j', 'a', 'b', 'fixed')), 'nothing moves between'),
    'planar': (robot('a b', joint('j', 'a', 'b', 'planar')),
               "joint 'j': type: got 'planar'; allowed: 'fixed', 'revolute'"),
    'no type': (robot('a b', '<joint name="j"><parent link="a"/><child link="b"/></joint>'),
                "joint 'j': type: got None"),
    'axis of two': (robot('a b', joint('j', 'a', 'b', parts='<axis xyz="0 1"/>')),
                    "joint 'j': axis: xyz: got '0 1'; allowed: 3 finite numbers"),
    'zero axis': (robot('a b', joint('j', 'a', 'b', parts='<axis xyz="0 0 0"/>')),
                  "joint 'j': axis must not be zero"),
    'nan': (robot('a b', joint('j', 'a', 'b', parts='<origin xyz="0 nan 0"/>')),
            "joint 'j': origin: xyz: got '0 nan 0'"),
    'infinite': (robot('a b', joint('j', 'a', 'b', parts='<origin rpy="0 0 1e999"/>')),
                 "joint 'j': origin: rpy: got '0 0 1e999'"),
    'not XML number': (robot('a b', joint('j', 'a', 'b', parts='<origin rpy="0 0 1_0"/>')),
                       "rpy: got '0 0 1_0'"),
    'overflow': (robot('a b c', *(joint(n, *n, parts='<origin xyz="1e308 0 0"/>')
                                  for n in ('ab', 'bc'))),
                 "joint 'bc': point must be finite"),
    'follows none': (robot('a b', joint('j', 'a', 'b', parts='<mimic joint="x"/>')),
                     r"joint 'j': mimic: joint: got 'x'; allowed: a joint \('j'\)"),
    'follows itself': (robot('a b', joint('j', 'a', 'b', parts='<mimic joint="j"/>')),
                       "joint 'j': mimic: got 'j', 'j'; allowed: .* no circle"),
    'follow in a circle': (
        robot('a b c', joint('j', 'a', 'b', parts='<mimic joint="k"/>'),
              joint('k', 'b', 'c', parts='<mimic joint="j"/>')),
        "joint 'j': mimic: got 'j', 'k', 'j'; allowed: .* no circle"),
    'follows a fixed one': (
        robot('a b c', joint('j', 'a', 'b', 'fixed'),
              joint('k', 'b', 'c', parts='<mimic joint="j"/>')),
        "joint 'k': mimic: joint: got 'j'; allowed: a joint that moves; this one is fixed"),
    'multiplier': (
        robot('a b c', joint('j', 'a', 'b'),
              joint('k', 'b', 'c', parts='<mimic joint="j" multiplier="x"/>')),
        "joint 'k': mimic: multiplier: got 'x'; allowed: a finite number"),
    'multiplier overflow': (
        robot('a b c d', joint('j', 'a', 'b'),
              joint('k', 'b', 'c', parts='<mimic joint="j" multiplier="1e200"/>'),
              joint('l', 'c', 'd', parts='<mimic joint="k" multiplier="1e200"/>')),
        "joint 'l': mimic: got multiplier inf"),
    'text in an origin': (
        robot('a b', joint('j', 'a', 'b', parts='<origin>0 0 1</origin>')),
        "got the text '0 0 1' in 'origin', which may change the joint; allowed: attributes"),
    'too many joints': (
        robot(' '.join(f'l{i}' for i in range(1002)),
              *(joint(f'j{i}', f'l{i}', f'l{i + 1}') for i in range(1001))),
        "1001 joints between base frame 'l0' and tip frame 'l1001'; allowed: at most 1000"),
    'too many elements': ('<robot>' + '<link name="a"/>' * 100_001, 'more than 100000 elements'),
    'too large': ('<robot>' + ' ' * 4_000_000, 'more than 4000000 bytes'),
}


@pytest.mark.parametrize('what', REFUSED)
def test_is_refused(what):
    text, message = REFUSED[what]
    with pytest.raises(ModelError, match=message) as caught:
        models.load_urdf(text, source='arm.urdf')
    assert str(caught.value).startswith('arm.urdf: ')
    assert len(str(caught.value)) < 2000


@pytest.mark.parametrize('frames, message', [
    (('x', None), r"base frame: got 'x'; allowed: a link \('a', 'b', 'c'\)"),
    ((None, 'x'), "tip frame: got 'x'; allowed: a link"),
    (('a', 'a'), "nothing moves between base frame 'a' and tip frame 'a'")])
def test_frames_are_links(frames, message):
    with pytest.raises(ModelError, match=message):
        models.load_urdf(TWO, *frames)


def test_errors_are_of_the_package():
    assert issubclass(ModelError, ScrewKinematicsError) and issubclass(ModelError, ValueError)

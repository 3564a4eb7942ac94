# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Where descriptions are found, by path, file URI, package URI, and through xacro."""
import sys

from hypothesis import given, settings, strategies as st
import pytest

from screw_kinematics import models
from screw_kinematics.errors import MissingExtraError, ModelError
from screw_kinematics.models.xacro_file import joined_arguments, split_arguments

ARM = 'joints: [{name: q, axis: [0, 0, 1]}]\nhome: {}\n'
URDF = """<robot name="r" xmlns:xacro="http://wiki.ros.org/xacro">
<xacro:property name="length" value="0.5"/><link name="a"/><link name="b"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="${2 * length} 0 0"/></joint></robot>"""


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / 'my arm.yaml'
    path.write_text(ARM)
    return path


def test_paths_and_file_uris(arm, monkeypatch):
    assert models.load(arm).name == 'my arm'
    assert models.load(str(arm)).joint_names == ('q',)
    assert models.load(arm.as_uri()).joint_names == ('q',)      # with %20
    assert models.load('file://localhost' + arm.as_uri()[7:]).joint_names == ('q',)
    monkeypatch.chdir(arm.parent)
    assert models.load('my arm.yaml').joint_names == ('q',)


def test_packages_are_found_in_workspaces(tmp_path, monkeypatch):
    """Overlay before underlay, by the ament index, as ROS looks packages up."""
    for name in ('overlay', 'underlay'):
        marker = tmp_path / name / 'share/ament_index/resource_index/packages/my_robot'
        marker.parent.mkdir(parents=True)
        marker.touch()
        (tmp_path / name / 'share/my_robot').mkdir()
        (tmp_path / name / 'share/my_robot/arm.yaml').write_text(f'name: {name}\n' + ARM)
    (tmp_path / 'underlay/share/my_robot/more.yaml').write_text(ARM)
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'{tmp_path}/overlay:{tmp_path}/underlay')
    assert models.load('package://my_robot/arm.yaml').name == 'overlay'
    assert models.load('package://my_robot/more.yaml').name == 'more'
    with pytest.raises(ModelError, match='package://my_robot/x.yaml: no such file in .*overlay'):
        models.load('package://my_robot/x.yaml')


def test_a_workspace_comes_before_all_else(tmp_path, monkeypatch):
    marker = tmp_path / 'share/ament_index/resource_index/packages/screw_kinematics'
    folder = tmp_path / 'share/screw_kinematics/config/robots'
    marker.parent.mkdir(parents=True)
    folder.mkdir(parents=True)
    marker.touch()
    (folder / 'rpr.yaml').write_text('name: mine\n' + ARM)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    assert models.load('package://screw_kinematics/config/robots/rpr.yaml').name == 'mine'
    assert models.load('package://screw_kinematics/config/robots/panda.yaml').name == 'panda'


@pytest.mark.parametrize('robot', ['puma560', 'rpr', 'panda'])
def test_own_robots_need_no_ros(robot, monkeypatch):
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    assert models.load(f'package://screw_kinematics/config/robots/{robot}.yaml').name == robot


@pytest.mark.parametrize('uri, message', [
    ('nowhere.yaml', '^nowhere.yaml: no such file$'),
    ('/', '^/: is a directory; allowed: a file'),
    ('file:///nowhere/arm.yaml', 'no such file: /nowhere/arm.yaml'),
    ('file://elsewhere/arm.yaml', 'no robot description can be read from there; allowed: pack'),
    ('http://example.com/arm.urdf', 'no robot description can be read from there; allowed: pack'),
    ('package:///arm.yaml', 'no robot description can be read from there'),
    ('package://not_there/arm.yaml', "package 'not_there' is not installed; looked in"),
    ('package://..%2F/arm.yaml', 'is not installed|no robot description'),
    ('arm\0.yaml', 'no such file'),
    ('file:///arm%00.yaml', 'no such file'),
    ('package://screw_kinematics/%00.yaml', 'no such file in'),
    ('x' * 5000 + '.yaml', 'no such file'),
    ('~nobody/arm.yaml', 'no such file'),
    ('http://[', 'no robot description'),
    ('', "^'': is no description; allowed: a path"), (' ', 'is no description'),
    (None, 'None: is no description; allowed: a path'),
    ('<?xml version="1.0"?>\n<robot name="r">' + '<link name="a"/>' * 1000,
     'is a description as text; allowed: a path or URI; text is for models.load_urdf'),
    (5, '5: is no description')])
def test_bad_uris_are_refused(uri, message):
    with pytest.raises(ModelError, match=message):
        models.load(uri)


def test_unknown_endings_are_refused(tmp_path):
    (tmp_path / 'arm.sdf').touch()
    with pytest.raises(ModelError, match="got '.sdf'; allowed: '.yaml', '.yml', '.urdf', '.xacr"):
        models.load(tmp_path / 'arm.sdf')


def test_unreadable_files_are_reported(tmp_path):
    """Linux refuses to read a process's memory at address 0, even to root."""
    path = tmp_path / 'arm.yaml'
    path.symlink_to('/proc/self/mem')
    with pytest.raises(ModelError, match='arm.yaml: cannot be read: .*Input/output error'):
        models.load(path)


def test_no_more_is_read_than_allowed(tmp_path):
    with (tmp_path / 'huge.urdf').open('wb') as file:
        file.truncate(1 << 40)      # sparse; reading it whole would fail
    with pytest.raises(ModelError, match='more than 4000000 bytes'):
        models.load(tmp_path / 'huge.urdf')


def test_xacro_is_expanded(tmp_path):
    pytest.importorskip('xacro')
    path = tmp_path / 'arm.urdf.xacro'
    path.write_text(URDF)
    assert models.load(path).joints[0].point.tolist() == [1, 0, 0]
    path.write_text(URDF.replace('length}', 'width}'))
    with pytest.raises(ModelError, match='arm.urdf.xacro: xacro: .*width'):
        models.load(path)


def test_xacro_files_take_arguments(tmp_path):
    pytest.importorskip('xacro')
    path = tmp_path / 'my arm.urdf.xacro'
    path.write_text(URDF.replace('name="r"', 'name="$(arg name)"').replace(
        '<xacro:property name="length" value="0.5"/>',
        '<xacro:arg name="name" default="arm"/><xacro:arg name="length" default="0.5"/>'
        '<xacro:property name="length" value="$(arg length)"/>'))
    chain = models.load(f'{path} name:="two words" length:=2.5')
    assert chain.name == 'two words' and chain.joints[0].point.tolist() == [5, 0, 0]
    assert models.load(path.as_uri() + ' name:=r').joints[0].point.tolist() == [1, 0, 0]
    # The name is asked for before the file declares its default.
    with pytest.raises(ModelError, match="argument 'name' has no value; give one as "
                       "'my arm.urdf.xacro name:=VALUE'; the file declares: 'name', 'length'"):
        models.load(path)
    chain = models.load(f'{path} name:=r lenght:=1')
    assert chain.warnings == ("argument 'lenght' is not declared by the file; it declares: "
                              "'length', 'name'",)


def test_arguments_are_for_xacro_alone(arm):
    with pytest.raises(ModelError, match="arguments: got 'a'; allowed: none, since only .xacro"):
        models.load(f'{arm} a:=1')


@settings(deadline=None, derandomize=True)     # the machine may stand still
@given(st.dictionaries(st.from_regex(r'[A-Za-z_][A-Za-z0-9_]*', fullmatch=True), st.text()))
def test_arguments_there_and_back(arguments):
    file = 'a file/of blanks.xacro'
    assert split_arguments(joined_arguments(file, arguments)) == (file, arguments)


def test_xacro_is_an_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'xacro', None)
    path = tmp_path / 'arm.xacro'
    path.write_text(URDF)
    with pytest.raises(MissingExtraError, match=r"arm.xacro.*'screw_kinematics\[xacro\]'"):
        models.load(path)


def test_macros_are_named_in_plain_urdf():
    with pytest.raises(ModelError, match='macro element .*expanded by xacro'):
        models.load_urdf(URDF)

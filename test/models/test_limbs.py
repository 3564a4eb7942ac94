# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Model files of parallel manipulators: what they mean, and what is refused."""
from copy import deepcopy

import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ModelError
from screw_kinematics.models.model_file import robot_from_data
from screw_kinematics.parallel import ParallelManipulator

LINKAGE = {
    'name': 'linkage', 'platform': {'xyz': [1, 1, 0]}, 'actuated': ['crank'],
    'limbs': [
        {'name': 'left', 'joints': [
            {'name': 'crank', 'axis': [0, 0, 1], 'point': [0, 0, 0], 'position': 0.5},
            {'name': 'left_pin', 'axis': [0, 0, 1], 'point': [0, 1, 0]}]},
        {'name': 'right', 'joints': [
            {'name': 'rocker', 'axis': [0, 0, 1], 'point': [2, 0, 0]},
            {'name': 'right_pin', 'kind': 'universal', 'axes': [[0, 0, 1], [1, 0, 0]],
             'point': [2, 1, 0]}]}]}


def read(data):
    return robot_from_data(data, 'linkage.yaml', 'linkage')


def changed(path, value):
    """Return the description with one entry set, or removed if the value is Ellipsis."""
    data = deepcopy(LINKAGE)
    at = data
    for key in path[:-1]:
        at = at[key]
    if value is ...:
        del at[path[-1]]
    else:
        at[path[-1]] = value
    return data


@pytest.mark.parametrize('name', ['planar_3rrr', 'delta', 'stewart_6ups'])
def test_shipped_robots_are_closed_where_they_are_drawn(name):
    robot = models.load(f'package://screw_kinematics/config/robots/{name}.yaml')
    assert isinstance(robot, ParallelManipulator)
    assert robot.home.iterations == 1
    assert np.max(robot.home.misfit) < 1e-13
    conditioning = robot.home.conditioning
    assert min(conditioning.direct, conditioning.inverse, conditioning.limbs) > 0.05
    assert (robot.name, robot.base_frame, robot.tip_frame) == (name, 'base', 'platform')


def test_drawn_posture_is_read_as_it_says():
    """The crank reads 0.5 where its pin is straight above it."""
    linkage = read(LINKAGE)
    assert linkage.joint_names == ('crank',)
    assert linkage.passive_joint_names == ('left_pin', 'rocker', 'right_pin_a', 'right_pin_b')
    np.testing.assert_array_equal(linkage.home.actuated, [0.5])
    for angle in (0.5, 0.8, -0.3):
        turned = angle - 0.5
        np.testing.assert_allclose(
            linkage.posture([angle]).pose[:3, 3], [1 - np.sin(turned), np.cos(turned), 0],
            atol=1e-12)


def test_units_are_converted():
    data = deepcopy(LINKAGE)
    data['units'] = {'length': 'mm', 'angle': 'deg'}
    for limb in data['limbs']:
        for joint in limb['joints']:
            joint['point'] = [1000 * x for x in joint['point']]
    data['platform']['xyz'] = [1000, 1000, 0]
    data['limbs'][0]['joints'][0]['position'] = np.degrees(0.5)
    a, b = read(data), read(LINKAGE)
    np.testing.assert_allclose(a.posture([0.9]).pose, b.posture([0.9]).pose, atol=1e-12)
    assert a.characteristic_length == pytest.approx(b.characteristic_length)


def test_frames_can_be_named_by_who_loads():
    linkage = robot_from_data(LINKAGE, 'linkage.yaml', 'linkage', 'world', 'plate')
    assert (linkage.base_frame, linkage.tip_frame) == ('world', 'plate')
    assert {(c.base_frame, c.tip_frame) for c in linkage.limbs} == {('world', 'plate')}


@pytest.mark.parametrize(('path', 'value', 'message'), [
    (['platform'], ..., r'linkage.yaml: platform: got None'),
    (['actuated'], ..., r'linkage.yaml: actuated: got None; allowed: a list of 1 to'),
    (['actuated'], ['motor'], "linkage.yaml: actuated joint 'motor' is in none of the limbs"),
    (['limbs'], [], r'linkage.yaml: limbs: got \[\]; allowed: a list of 1 to 100 entries'),
    (['limbs', 1], 7, 'limb 2: got 7; allowed: keys with values'),
    (['limbs', 1, 'name'], 'left', "limb 'left' occurs more than once"),
    (['limbs', 1, 'mass'], 1, "limb 'right': unknown key 'mass'; allowed: 'name', 'joints'"),
    (['limbs', 0, 'joints', 0, 'name'], ..., "limb 'left': joint 1: name: got None"),
    (['limbs', 0, 'joints', 0, 'axis'], [0, 0, 0], "joint 'crank': axis must not be zero"),
    (['limbs', 0, 'joints', 0, 'position'], 'far', "joint 'crank': position: got 'far'"),
    (['limbs', 0, 'joints', 0, 'mimic'], {'joint': 'rocker'},
     "joint 'crank': position: a joint that follows another one has none"),
    (['limbs', 1, 'joints', 1, 'axes'], [[0, 0, 1]],
     r"joint 'right_pin': axes: got \[\[0, 0, 1\]\]; allowed: 2 directions"),
    (['limbs', 1, 'joints', 1, 'axes'], [[0, 0, 1], [1, 0]],
     r"joint 'right_pin': axes: b: got \[1, 0\]; allowed: 3 finite numbers"),
    (['limbs', 1, 'joints', 1, 'pitch'], 0.1, "joint 'right_pin': pitch: a universal joint has"),
    (['limbs', 1, 'joints', 0, 'kind'], 'ball', "joint 'rocker': kind: got 'ball'; allowed: "
                                                "'revolute', 'continuous'"),
    (['actuated'], ['right_pin_b'],
     'linkage.yaml: with the actuated joints right_pin_b locked the platform can still move'),
])
def test_refused(path, value, message):
    with pytest.raises(ModelError, match=message):
        read(changed(path, value))


def test_all_joints_may_be_measured():
    """That is redundant, not wrong."""
    joints = ['crank', 'left_pin', 'rocker', 'right_pin_a', 'right_pin_b']
    linkage = read(changed(['actuated'], joints))
    assert (linkage.dof, linkage.mobility, linkage.passive_joint_names) == (5, 1, ())
    state = linkage.state([0.8, -0.3, 0.3, -0.3, 0.0], [1.0, -1.0, 1.0, -1.0, 0.0])
    np.testing.assert_allclose(
        state.velocity, [0, 0, 0, -np.cos(0.3), -np.sin(0.3), 0], atol=1e-12)

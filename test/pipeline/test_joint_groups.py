# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints by name: whatever the order, the neighbours and the number of messages."""
import random

import pytest
from screw_kinematics.errors import Reason
from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.pipeline.joint_groups import JointGroups, MAX_LAYOUTS

JOINTS = ('a', 'b', 'c', 'd')


def read(groups, names, values=None):
    """Return what the groups read in a message with these names."""
    values = tuple(float(k) for k in range(len(names))) if values is None else values
    return groups.read(JointSample(5, tuple(names), values, ()))


@pytest.mark.parametrize('seed', range(5))
def test_values_come_in_the_order_of_the_robot(seed):
    rng = random.Random(seed)
    names = [*JOINTS, 'x', 'y']
    rng.shuffle(names)
    reading = read(JointGroups(JOINTS), names)
    assert reading.group.complete
    assert tuple(reading.position) == tuple(names.index(n) for n in JOINTS)


def test_same_order_and_number_is_passed_on_as_it_is():
    values = (1.0, 2.0, 3.0, 4.0)
    assert read(JointGroups(JOINTS), JOINTS, values).position is values


def test_parts_make_up_the_robot():
    groups = JointGroups(JOINTS)
    assert groups.missing() == list(JOINTS)
    first, second = read(groups, ('c', 'a')), read(groups, ('d', 'b'))
    assert (first.group.columns, second.group.columns) == ((0, 2), (1, 3))
    assert not first.group.complete and groups.missing() == []


def test_same_joints_in_another_order_are_the_same_group():
    groups = JointGroups(JOINTS)
    assert read(groups, ('a', 'b')).group is read(groups, ('b', 'lamp', 'a')).group


def test_a_larger_message_takes_over():
    groups = JointGroups(JOINTS)
    read(groups, ('a', 'b'))
    assert read(groups, JOINTS).group.complete
    assert len(groups.groups) == 1
    assert read(groups, ('a', 'b')) is Reason.OWNED_BY_OTHERS


def test_an_overlapping_message_counts_for_the_rest():
    groups = JointGroups(JOINTS)
    read(groups, ('a', 'b', 'c'))
    assert read(groups, ('d', 'c')).group.columns == (3,)
    assert groups.missing() == []


def test_a_released_group_leaves_its_joints_to_others():
    groups = JointGroups(JOINTS)
    group = read(groups, ('a', 'b', 'c')).group
    assert read(groups, ('b', 'a')) is Reason.OWNED_BY_OTHERS
    groups.release(group)
    assert groups.missing() == list(JOINTS)
    assert read(groups, ('b', 'a')).group.columns == (0, 1)


@pytest.mark.parametrize('names, reason', [
    ((), Reason.NO_JOINT), (('lamp',), Reason.NO_JOINT), (('a', 'b', 'a'), Reason.NAMED_TWICE)])
def test_refusals_have_a_reason(names, reason):
    assert read(JointGroups(JOINTS), names) is reason


def test_endlessly_new_names_take_no_more_memory():
    groups = JointGroups(JOINTS)
    for i in range(5 * MAX_LAYOUTS):
        assert read(groups, (*JOINTS, f'x{i}')).group is read(groups, JOINTS).group
    assert len(groups._layouts) <= MAX_LAYOUTS


@pytest.mark.parametrize('met, told', [
    (('left_arm_joint_1', 'lamp'), "; there are some of 'left_arm_joint_1'"),
    (('ARM_JOINT_1',), "; there are some of 'ARM_JOINT_1'"),
    (('arm_joint1',), "; there are some of 'arm_joint1'"),
    (('lamp', 'door'), '; there are some of lamp, door'),
    ((), '')])
def test_names_that_may_be_meant_are_told(met, told):
    groups = JointGroups(['arm_joint_1'])
    read(groups, met)
    assert groups.describe_missing() == f'no joint states of arm_joint_1{told}'


def test_endless_strangers_are_not_remembered():
    groups = JointGroups(JOINTS)
    for i in range(1000):
        read(groups, [f'x{i}'])
    assert len(groups.describe_missing()) < 300

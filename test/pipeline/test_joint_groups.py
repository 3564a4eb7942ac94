# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Joints by name: whatever the order, the neighbours and the number of messages."""
import random

import pytest
from screw_kinematics.pipeline.joint_groups import (
    JointGroups, MAX_LAYOUTS, NAMED_TWICE, NO_JOINT, OWNED)

JOINTS = ('a', 'b', 'c', 'd')


@pytest.mark.parametrize('seed', range(5))
def test_values_come_in_the_order_of_the_robot(seed):
    rng = random.Random(seed)
    names = [*JOINTS, 'x', 'y']
    rng.shuffle(names)
    layout = JointGroups(JOINTS).find(tuple(names))
    assert layout.group.complete
    assert tuple(layout.pick([names.index(n) + 0.5 for n in names])) == tuple(
        names.index(n) + 0.5 for n in JOINTS)


def test_same_order_and_number_is_passed_on_as_it_is():
    values = (1.0, 2.0, 3.0, 4.0)
    assert JointGroups(JOINTS).find(JOINTS).pick(values) is values


def test_parts_make_up_the_robot():
    groups = JointGroups(JOINTS)
    assert groups.missing() == list(JOINTS)
    first, second = groups.find(('c', 'a')), groups.find(('d', 'b'))
    assert (first.group.columns, second.group.columns) == ((0, 2), (1, 3))
    assert not first.group.complete and groups.missing() == []
    assert groups.names_of(second.group) == ['b', 'd']


def test_same_joints_in_another_order_are_the_same_group():
    groups = JointGroups(JOINTS)
    assert groups.find(('a', 'b')).group is groups.find(('b', 'lamp', 'a')).group


def test_a_larger_message_takes_over():
    groups = JointGroups(JOINTS)
    groups.find(('a', 'b'))
    assert groups.find(JOINTS).group.complete
    assert len(groups.groups) == 1
    assert groups.find(('a', 'b')) == OWNED


def test_an_overlapping_message_counts_for_the_rest():
    groups = JointGroups(JOINTS)
    groups.find(('a', 'b', 'c'))
    assert groups.find(('d', 'c')).group.columns == (3,)
    assert groups.missing() == []


def test_a_released_group_leaves_its_joints_to_others():
    groups = JointGroups(JOINTS)
    group = groups.find(('a', 'b', 'c')).group
    assert groups.find(('b', 'a')) == OWNED
    groups.release(group)
    assert groups.missing() == list(JOINTS)
    assert groups.find(('b', 'a')).group.columns == (0, 1)


@pytest.mark.parametrize('names, reason', [
    ((), NO_JOINT), (('lamp',), NO_JOINT), (('a', 'b', 'a'), NAMED_TWICE)])
def test_refusals_have_a_reason(names, reason):
    assert JointGroups(JOINTS).find(names) == reason


def test_endlessly_new_names_take_no_more_memory():
    groups = JointGroups(JOINTS)
    for i in range(5 * MAX_LAYOUTS):
        assert groups.find((*JOINTS, f'x{i}')).group is groups.find(JOINTS).group
    assert len(groups._layouts) <= MAX_LAYOUTS

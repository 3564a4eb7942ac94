# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Positions in other units are told by their size, joints that turn on by their jumps."""
import re

import numpy as np
import pytest
from screw_kinematics.errors import InvalidValueError, Reason
from screw_kinematics.motion import smooth
from screw_kinematics.motion.units import unit_doubts

T = np.arange(2000) / 250.0
SWING = 1.2 * np.sin(2 * np.pi * 0.25 * T)
TURNING = np.remainder(3.0 * T + np.pi, 2 * np.pi) - np.pi


@pytest.mark.parametrize('position, kind, problem, advice', [
    (np.degrees(SWING), 'revolute', r'reaches 68.75 rad, 10.9 turns', 'are these degrees'),
    (np.rint(np.degrees(SWING)), 'revolute', r'reaches 69 rad', 'ticks of an encoder, or degrees'),
    (np.rint(SWING * 256 / (2 * np.pi)), 'revolute', 'reaches 49 rad', 'ticks of an encoder, or'),
    (np.rint(SWING * 1e4), 'revolute', r'reaches 1.2e\+04 rad', 'whole numbers, of an encoder'),
    (np.rint(SWING * 1e4), '', r'reaches 1.2e\+04 rad or m', 'whole numbers, of an encoder'),
    (np.degrees(TURNING), 'continuous', 'reaches 180 rad', 'are these degrees'),
    (300 * SWING, 'prismatic', 'is a slide and reaches 360 m', 'are these mm.*must be in m$'),
    (TURNING, 'revolute', 'jumps by a whole turn, 6.283, 4 times', "declare it 'continuous'"),
    (TURNING[:500], 'revolute', 'jumps by a whole turn, 6.283, once', "declare it 'continuous'")])
def test_what_is_odd_is_told(position, kind, problem, advice):
    doubt, = unit_doubts(position, kind)
    assert re.search(problem, doubt.problem) and re.search(advice, doubt.advice), doubt


@pytest.mark.parametrize('position, kind', [
    (SWING, 'revolute'), (SWING, ''), (TURNING, 'continuous'), (50.1 * T, 'continuous'),
    (SWING, 'prismatic'), (np.full(9, np.nan), 'revolute'), (np.zeros(0), '')])
def test_sound_positions_raise_no_doubt(position, kind):
    assert unit_doubts(position, kind) == []


def test_smoothing_tells_it_by_the_names_of_the_joints_and_what_was_refused():
    positions = np.degrees(np.stack([SWING, 0.01 * SWING], axis=1))
    result = smooth(T, positions, joint_names=['elbow', 'wrist'])
    assert result.findings == ('elbow reaches 68.75 rad or m: are these degrees or mm?: positions '
                               'must be in rad or m',)
    assert result.refused.keys() == {Reason.IMPLAUSIBLE_JUMP, Reason.RUN_TOO_SHORT}
    assert sum(result.refused.values()) == (~result.used).sum()
    with pytest.raises(InvalidValueError, match='no run .*; [0-9]+ of 2000 refused: '
                       'implausible_jump; .* joint 0 reaches 1.2e.* whole numbers, of an encoder'):
        smooth(T, np.rint(1e5 * SWING)[:, None])

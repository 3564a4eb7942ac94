# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Parallel manipulators: closed loops of screws.

A platform is carried by limbs, open chains whose joints are partly measured (actuated) and
partly passive. :class:`ParallelManipulator` finds the posture from the measured joints,
and states of every order from their rates.
"""
from .closed_posture import ClosedPosture
from .manipulator import ParallelManipulator
from .program import ParallelProgram
from .screw_system import Conditioning

__all__ = ['ClosedPosture', 'Conditioning', 'ParallelManipulator', 'ParallelProgram']

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The algebra of six-vectors: the group SE(3), its Lie algebra se(3), lines, screws and states.

Everything here runs on floats, on batches, on symbols and on traced scalars alike.
"""
from . import lines, se3, states
from .axodes import Axodes, axodes
from .body_state import BodyState
from .cylindroid import Cylindroid, cylindroid, third_axis
from .screw import (
    are_reciprocal, prismatic_screw, reciprocal_screws, Screw, screw_of_displacement,
    screw_of_twist, unit_screw)

__all__ = ['Axodes', 'BodyState', 'Cylindroid', 'Screw', 'are_reciprocal', 'axodes', 'cylindroid',
           'lines', 'prismatic_screw', 'reciprocal_screws', 'screw_of_displacement',
           'screw_of_twist', 'se3', 'states', 'third_axis', 'unit_screw']

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Straight-line programs: traced from an algorithm once, then run, or written as source text."""
from .program import Program
from .straight_line_program import StraightLineProgram
from .tracing import Graph, straight_line

__all__ = ['Graph', 'Program', 'StraightLineProgram', 'straight_line']

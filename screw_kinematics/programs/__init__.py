# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Straight-line programs: traced from an algorithm once, then run, or written as source text."""
from .instructions import StraightLine
from .program import Program
from .tracing import Graph, straight_line

__all__ = ['Graph', 'Program', 'StraightLine', 'straight_line']

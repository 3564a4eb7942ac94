# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""All that needs SymPy: exact chains, formulas that people read, and their printing."""
from .exact import dh_chain, DHJoint, each, exact_chain, exact_length, sympy_array
from .expressions import coordinates, simplify, six_vector, state
from .printing import c_source, latex, python_source

__all__ = ['DHJoint', 'c_source', 'coordinates', 'dh_chain', 'each', 'exact_chain',
           'exact_length', 'latex', 'python_source', 'simplify', 'six_vector', 'state',
           'sympy_array']

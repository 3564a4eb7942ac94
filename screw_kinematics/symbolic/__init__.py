# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""All that needs SymPy: exact chains, formulas that people read, and their printing."""
from .exact import (
    dh_chain, DHJoint, elementwise, exact_chain, exact_decimal, sympy_array)
from .expressions import joint_symbols, parameter, simplify, six_vector, symbolic_state
from .printing import c_source, latex, python_source

__all__ = ['DHJoint', 'c_source', 'dh_chain', 'elementwise', 'exact_chain', 'exact_decimal',
           'joint_symbols', 'latex', 'parameter', 'python_source', 'simplify', 'six_vector',
           'symbolic_state', 'sympy_array']

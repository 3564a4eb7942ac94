# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Twist, acceleration, jerk and jounce of manipulators by screw theory.

The library needs NumPy only; nothing here imports ROS.
"""
from . import lines, screws, se3, states
from .body_state import BodyState
from .chain import SerialChain
from .inverse import InverseSolver
from .joint import Joint, Mimic

__all__ = ['BodyState', 'InverseSolver', 'Joint', 'Mimic', 'SerialChain', 'lines', 'screws',
           'se3', 'states']

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Twist, acceleration, jerk and jounce of manipulators by screw theory.

The library needs NumPy only; nothing here imports ROS.
"""
from . import screws
from .chains.inverse import InverseSolver
from .chains.joint import Joint, Mimic
from .chains.serial_chain import SerialChain
from .screws import lines, se3, states
from .screws.body_state import BodyState

__all__ = ['BodyState', 'InverseSolver', 'Joint', 'Mimic', 'SerialChain', 'lines', 'screws',
           'se3', 'states']

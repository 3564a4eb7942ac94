# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Open chains of joints: posture, states of every order, inverse rates, compiled programs."""
from .inverse import InverseSolution, InverseSolver, Manipulability
from .joint import Joint, Mimic
from .posture import Posture
from .serial_chain import SerialChain

__all__ = ['InverseSolution', 'InverseSolver', 'Joint', 'Manipulability', 'Mimic', 'Posture',
           'SerialChain']

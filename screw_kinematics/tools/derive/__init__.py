# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Formulas and source code of a robot."""

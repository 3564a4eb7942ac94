# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A publisher of joint states that moves a robot by a reference motion."""

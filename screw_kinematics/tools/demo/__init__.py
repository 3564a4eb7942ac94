# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node, a source of joint states, and the states live in the terminal."""

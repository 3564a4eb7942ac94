# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How fast many recordings become states, on how many processes, in how much memory."""

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""States of the robots in a recording."""

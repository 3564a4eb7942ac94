# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What tests share: robots, exact motions, a node in its own process."""

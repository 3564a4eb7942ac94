# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A robot and its measured motion in the browser: recorded or live."""

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Measurements of speed, memory and accuracy, side by side with peers."""

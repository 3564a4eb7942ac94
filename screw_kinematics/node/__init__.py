# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node: all that imports rclpy for it, and no mathematics."""

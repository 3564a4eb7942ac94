# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Serialized messages: joint states in, stamped geometry messages out and in; no rclpy."""

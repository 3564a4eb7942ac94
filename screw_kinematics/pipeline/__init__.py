# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One robot of the node, without ROS: settings, model, and the way of a sample."""

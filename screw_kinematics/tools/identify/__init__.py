# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the node that measurements tell: the payload of a force sensor."""

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of motions, screws and recordings."""

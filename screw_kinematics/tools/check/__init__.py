# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is odd about models, recordings and a running system."""

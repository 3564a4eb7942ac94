# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How well joint accelerations are estimated: motions x measurement conditions x estimators."""

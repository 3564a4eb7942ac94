# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Robots as the field has them, each stamped in another way; `python -m benchmark.soak.field`."""

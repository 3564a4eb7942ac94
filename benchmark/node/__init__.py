# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the node costs, beside others that do the same or less; `python -m benchmark.node`."""

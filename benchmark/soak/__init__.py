# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node for a long time, with faults, every output checked; `python -m benchmark.soak`."""

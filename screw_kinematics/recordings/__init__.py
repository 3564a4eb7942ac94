# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of joint states, and the states of robots made from them."""

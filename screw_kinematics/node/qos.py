# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The quality of service of what is listened to."""
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


def input_qos() -> QoSProfile:
    """
    Return the default quality of service of an input.

    Best effort and volatile as the sensor data profile, so that it matches publishers of
    either kind, but with a longer queue: a burst must not lose samples.
    """
    return QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT,
                      durability=DurabilityPolicy.VOLATILE)


def latched_qos() -> QoSProfile:
    """Return that by which a message that was sent before, as a description, is received too."""
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

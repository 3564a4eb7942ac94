# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Unit quaternions (x, y, z, w), the form of orientations in ROS messages."""
from __future__ import annotations

from collections.abc import Sequence
from math import sqrt


def quaternion_from_rotation(rotation: Sequence[float]) -> tuple[float, float, float, float]:
    """
    Return the unit quaternion of a rotation matrix.

    Of the two that exist, the one with w >= 0.

    Parameters
    ----------
    rotation : sequence of 9 float
        The rotation matrix, row by row.

    Returns
    -------
    tuple of 4 float
        x, y, z, w.

    References
    ----------
    S. W. Shepperd, "Quaternion from rotation matrix", Journal of Guidance and Control 1(3),
    1978: divide by the largest component, which is at least 1/2.

    Examples
    --------
    >>> quaternion_from_rotation([1, 0, 0, 0, -1, 0, 0, 0, -1])
    (1.0, 0.0, 0.0, 0.0)

    """
    xx, xy, xz, yx, yy, yz, zx, zy, zz = rotation
    trace = xx + yy + zz
    if trace >= max(xx, yy, zz):
        x, y, z, w = zy - yz, xz - zx, yx - xy, 1.0 + trace
    elif xx >= yy and xx >= zz:
        x, y, z, w = 1.0 + xx - yy - zz, xy + yx, xz + zx, zy - yz
    elif yy >= zz:
        x, y, z, w = xy + yx, 1.0 - xx + yy - zz, yz + zy, xz - zx
    else:
        x, y, z, w = xz + zx, yz + zy, 1.0 - xx - yy + zz, yx - xy
    scale = 1.0 / sqrt(x * x + y * y + z * z + w * w)
    if w < 0.0:
        scale = -scale
    return x * scale, y * scale, z * scale, w * scale

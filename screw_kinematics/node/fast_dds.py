# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the middleware that are made before it starts, by its environment variables."""
from __future__ import annotations

from collections.abc import MutableMapping
from importlib.util import find_spec
import os
from pathlib import Path
from typing import NamedTuple

from ..errors import ModelError
from ..models.uri import local_path


class Generation(NamedTuple):
    """Where one generation of Fast DDS looks for its settings, and ours for it."""

    variables: tuple[str, ...]    # name a file, the first is to be used; of no other middleware
    in_working_directory: str     # the file that it reads without being asked
    profile: str                  # our file, in config/


FAST_DDS_2 = Generation(
    ('FASTRTPS_DEFAULT_PROFILES_FILE',), 'DEFAULT_FASTRTPS_PROFILES.xml', 'fast_dds_2.xml')
# Its adapter in ROS still heeds the former name, with a warning.
FAST_DDS_3 = Generation(
    ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE'),
    'DEFAULT_FASTDDS_PROFILES.xml', 'fast_dds_3.xml')


def settle(environment: MutableMapping[str, str] = os.environ,
           generation: Generation | None = None) -> None:
    """
    Give Fast DDS our settings, unless the user has given it some; before the middleware starts.

    The generation is by default the one that comes with ROS as it is installed here.
    """
    own = generation or installed()
    if any(name in environment for name in own.variables) \
            or os.path.exists(own.in_working_directory):
        return
    try:
        environment[own.variables[0]] = str(
            local_path(f'package://screw_kinematics/config/{own.profile}'))
    except ModelError:
        pass    # installed without its data files: slower, and otherwise the same


def installed() -> Generation:
    """Return the generation that comes with the ROS of rclpy: the third from Kilted on."""
    rclpy = find_spec('rclpy')
    # importlib.metadata would take a twentieth of the node's start, and 2 MiB.
    releases = [] if rclpy is None or rclpy.origin is None else [
        path.name.split('-')[1] for path in Path(rclpy.origin).parents[1].glob('rclpy-*-info')]
    jazzy_or_older = int(releases[0].partition('.')[0]) <= 7 if releases else (
        os.environ.get('ROS_DISTRO', '') in ('humble', 'iron', 'jazzy'))
    return FAST_DDS_2 if jazzy_or_older else FAST_DDS_3

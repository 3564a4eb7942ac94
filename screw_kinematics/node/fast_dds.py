# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the middleware that are made before it starts, by its environment variables."""
from __future__ import annotations

from collections.abc import MutableMapping
import os

from ..errors import ModelError
from ..models.uri import local_path

PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE'
"""Where Fast DDS looks for its settings; other middlewares do not know it."""

IN_WORKING_DIRECTORY = 'DEFAULT_FASTRTPS_PROFILES.xml'
"""The other place where it looks."""


def settle(environment: MutableMapping[str, str] = os.environ) -> None:
    """
    Give Fast DDS the settings in ``config/fast_dds.xml``, unless the user has given some.

    To be called before the middleware starts.

    Parameters
    ----------
    environment : mapping from str to str
        The variables of the process.

    """
    if PROFILES in environment or os.path.exists(IN_WORKING_DIRECTORY):
        return
    try:
        environment[PROFILES] = str(local_path('package://screw_kinematics/config/fast_dds.xml'))
    except ModelError:
        pass    # installed without its data files: slower, and otherwise the same

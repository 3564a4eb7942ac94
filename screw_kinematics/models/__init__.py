# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Robot descriptions and how they become chains or parallel manipulators.

Formats: model files in YAML (:mod:`.model_file`), URDF, and xacro
where it is installed.
"""
from .loading import load
from .urdf import load_urdf

__all__ = ['load', 'load_urdf']

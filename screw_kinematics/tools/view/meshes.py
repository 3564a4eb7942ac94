# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The bodies of a robot's links, from the meshes and shapes of its URDF."""
from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...chains.manipulator import Manipulator
from ...errors import ModelError, ScrewKinematicsError
from ...models.uri import local_path
from ...models.xacro_file import split_arguments
from ...screws.rotations import quaternion_from_rotation
from ...screws.se3 import Array, inverse


class RobotMeshes:
    """The bodies of a URDF, placed by the positions of a chain's joints."""

    def __init__(self, urdf: Any, robot: Manipulator) -> None:
        self._urdf = urdf
        self._robot = robot
        self._cfg = {name: 0.0 for name in urdf.actuated_joint_names}
        self._bodies: Any = None
        self._frame: Any = None

    def add_to(self, server: Any, root: str) -> None:
        """Add the bodies to a scene, below a node."""
        from viser.extras import ViserUrdf
        self._frame = server.scene.add_frame(root, show_axes=False)
        self._bodies = ViserUrdf(server, self._urdf, root_node_name=root)

    def move(self, q: Array) -> None:
        """Place the bodies for positions of the measured joints; all others are at 0."""
        positions = dict(zip(self._robot.joint_names, q.tolist()))
        self._bodies.update_cfg(np.array(
            [positions.get(name, value) for name, value in self._cfg.items()]))
        root = self._urdf.base_link
        if root != self._robot.base_frame:
            T_base_root = inverse(np.asarray(    # noqa: N806
                self._urdf.get_transform(self._robot.base_frame, root)))
            self._frame.wxyz = w_first(T_base_root[:3, :3])
            self._frame.position = T_base_root[:3, 3]


def load_meshes(description: str, robot: Manipulator) -> tuple[RobotMeshes | None, str]:
    """Return the bodies of a robot, or None and why there are none."""
    try:
        import yourdfpy
    except ImportError:
        return None, 'the package yourdfpy is not installed'
    try:
        source, folder = _source(description)
    except ScrewKinematicsError as error:
        return None, str(error)
    if source is None:
        return None, 'the model has none'
    try:
        urdf = yourdfpy.URDF.load(
            source, filename_handler=lambda fname: _mesh_file(fname, folder))
    except Exception as error:     # whatever readers of meshes raise
        return None, f'{type(error).__name__}: {error}'.splitlines()[0]
    if not urdf.scene.geometry:
        return None, 'the description has none'
    return RobotMeshes(urdf, robot), ''


def w_first(rotation: Array) -> Array:
    """Return a rotation as viser has it: a quaternion (w, x, y, z)."""
    return np.roll(quaternion_from_rotation(rotation), 1)


def _source(description: str) -> tuple[Any, Path]:
    """Return what yourdfpy reads, and the folder that relative names start from."""
    if description.lstrip().startswith('<'):
        from io import BytesIO
        return BytesIO(description.encode()), Path()
    file, _ = split_arguments(description)
    path = local_path(file)
    return (str(path) if path.suffix.lower() == '.urdf' else None), path.parent


def _mesh_file(name: str, folder: Path) -> str:
    """Return the path of a mesh: by its URI, or in the packages around the description."""
    try:
        return str(local_path(name if '://' in name else str(folder / name)))
    except ModelError:
        relative = name.partition('://')[2]
        for parent in (folder, *folder.parents):
            # With the package's name, and without: descriptions are often copied out of theirs.
            for part in (relative, relative.partition('/')[2]):
                if part and (parent / part).is_file():
                    return str(parent / part)
        raise

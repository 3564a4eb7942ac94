# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One way in for every kind of robot description."""
from __future__ import annotations

import os
from pathlib import Path

from .fields import listed
from .guarded_xml import MAX_BYTES
from .guarded_yaml import read_yaml
from .model_file import chain_from_data
from .parallel_file import manipulator_from_data
from .urdf import load_urdf
from .uri import local_path
from ..chains.serial_chain import SerialChain
from ..errors import MissingExtraError, ModelError
from ..parallel import ParallelManipulator

ENDINGS = ('.yaml', '.yml', '.urdf', '.xacro')


def load(uri: str | os.PathLike[str], base_frame: str | None = None,
         tip_frame: str | None = None) -> SerialChain | ParallelManipulator:
    """
    Return the robot a file describes.

    Parameters
    ----------
    uri : str or path
        ``package://<package>/<path>``, ``file:///<path>`` or a path, ending in .yaml or
        .yml (a model file), .urdf, or .xacro (needs the package xacro).
    base_frame, tip_frame : str, optional
        Frames the motion is measured between. Default: what a model file says; the root
        link and the only leaf of a URDF.

    Returns
    -------
    SerialChain or ParallelManipulator
        The latter from a model file with limbs.

    Raises
    ------
    ModelError
        The file is not found, not readable, or no valid description; the message names
        file, joint, key, value, and what is allowed.
    MissingExtraError
        The file needs xacro, which is not installed.

    Examples
    --------
    >>> load('package://screw_kinematics/config/robots/puma560.yaml').joint_names
    ('q1', 'q2', 'q3', 'q4', 'q5', 'q6')

    """
    source = os.fspath(uri)
    path = local_path(source)
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise ModelError(source, f'ending: got {ending!r}; allowed: {listed(ENDINGS)}')
    if ending == '.xacro':
        return load_urdf(_expand_xacro(source, path), base_frame, tip_frame, source)
    content = _content(source, path)
    if ending == '.urdf':
        return load_urdf(content, base_frame, tip_frame, source)
    data = read_yaml(source, content)
    read = manipulator_from_data if isinstance(data, dict) and 'limbs' in data \
        else chain_from_data
    return read(data, source, path.stem, base_frame, tip_frame)


def _content(source: str, path: Path) -> bytes:
    try:
        with path.open('rb') as file:
            return file.read(MAX_BYTES + 1)     # one more, for the reader to refuse
    except OSError as error:
        raise ModelError(source, f'cannot be read: {error.strerror or error}') from error


def _expand_xacro(source: str, path: Path) -> str:
    try:
        import xacro
    except ImportError:
        raise MissingExtraError('xacro', 'xacro', f'reading {source}') from None
    try:
        text: str = xacro.process_file(str(path)).toxml()
    except Exception as error:      # xacro raises whatever the file's expressions raise
        raise ModelError(source, f'xacro: {error}') from error
    return text

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One way in for every kind of robot description."""
from __future__ import annotations

from collections.abc import Callable
import os
from pathlib import Path
from typing import Any

from .fields import listed, shown
from .guarded_xml import MAX_BYTES
from .guarded_yaml import read_yaml
from .model_file import robot_from_data
from .parameters import with_parameters
from .urdf import load_urdf
from .uri import local_path
from .xacro_file import expand, split_arguments
from ..chains.serial_chain import SerialChain
from ..errors import ModelError
from ..parallel import ParallelManipulator

ENDINGS = ('.yaml', '.yml', '.urdf', '.xacro')


def load(uri: str | os.PathLike[str], base_frame: str | None = None,
         tip_frame: str | None = None,
         symbol: Callable[[str], Any] | None = None) -> SerialChain | ParallelManipulator:
    """
    Return the robot a file describes.

    Parameters
    ----------
    uri : str or path
        ``package://<package>/<path>``, ``file:///<path>`` or a path, ending in .yaml or
        .yml (a model file), .urdf, or .xacro (needs the package xacro). The last may have
        arguments behind it: ``arm.urdf.xacro name:=ur ur_type:=ur5e``.
    base_frame, tip_frame : str, optional
        Frames the motion is measured between. Default: what a model file says; the root
        link and the only leaf of a URDF.
    symbol : callable, optional
        Makes a symbol of the name of a length; those that a model file of an open chain
        names then stay symbols, for formulas. Default: lengths are numbers.

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
    if not isinstance(uri, (str, os.PathLike)) or not str(uri).strip():
        raise ModelError(repr(uri), 'is no description; allowed: a path or URI')
    if str(uri).lstrip().startswith('<'):
        raise ModelError(shown(str(uri)), 'is a description as text; allowed: a path or URI; text '
                         'is for models.load_urdf')
    source, arguments = split_arguments(os.fspath(uri))
    path = local_path(source)
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise ModelError(source, f'ending: got {ending!r}; allowed: {listed(ENDINGS)}')
    if ending == '.xacro':
        text, warnings = expand(source, path, arguments)
        return load_urdf(text, base_frame, tip_frame, source, warnings)
    if arguments:
        raise ModelError(source, f'arguments: got {listed(arguments)}; allowed: none, since '
                         'only .xacro files take any')
    content = _content(source, path)
    if ending == '.urdf':
        return load_urdf(content, base_frame, tip_frame, source)
    data = read_yaml(source, content)
    closed = isinstance(data, dict) and 'limbs' in data
    data = with_parameters(data, source, None if closed else symbol)
    return robot_from_data(data, source, path.stem, base_frame, tip_frame)


def _content(source: str, path: Path) -> bytes:
    try:
        with path.open('rb') as file:
            return file.read(MAX_BYTES + 1)     # one more, for the reader to refuse
    except OSError as error:
        raise ModelError(source, f'cannot be read: {error.strerror or error}') from error

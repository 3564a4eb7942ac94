# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where robot descriptions are: plain paths, ``file://`` and ``package://`` URIs.

Files are only ever read.
"""
from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import sys
from urllib.parse import unquote, urlsplit

from .fields import listed
from ..errors import ModelError

_THIS_PACKAGE = 'screw_kinematics'
_SOURCE_TREE = Path(__file__).resolve().parents[2]


def local_path(uri: str) -> Path:
    """
    Return the path of the file a URI names.

    Parameters
    ----------
    uri : str
        ``package://<package>/<path>``, ``file:///<path>`` or a plain path.

    Raises
    ------
    ModelError
        The scheme is another one, the package is not found, or there is no such file.

    Examples
    --------
    >>> local_path('package://screw_kinematics/config/robots/puma560.yaml').name
    'puma560.yaml'

    """
    if '\0' in uri:
        raise ModelError(repr(uri), 'path with a zero byte; allowed: a path or URI')
    parts = urlsplit(uri) if '://' in uri else None
    if parts is None:
        path = Path(uri).expanduser()
    elif parts.scheme == 'file' and parts.netloc in ('', 'localhost'):
        path = Path(unquote(parts.path))
    elif parts.scheme == 'package' and parts.netloc:
        path = _package_file(uri, parts.netloc, unquote(parts.path).lstrip('/'))
    else:
        raise ModelError(uri, 'no robot description can be read from there; allowed: '
                         'package://<package>/<path>, file:///<path>, or a path')
    if not path.is_file():
        raise ModelError(uri, f'no such file: {path}')
    return path


def _package_file(uri: str, package: str, relative: str) -> Path:
    shares = list(_shares(package))
    for share in shares:
        if (share / relative).is_file():
            return share / relative
    if shares:
        raise ModelError(uri, f'no such file in {listed(map(str, shares))}')
    raise ModelError(uri, f'package {package!r} is not installed; looked in the workspaces of '
                     f'AMENT_PREFIX_PATH and in {Path(sys.prefix) / "share"}')


def _shares(package: str) -> Iterator[Path]:
    """Yield the share directories of a package: overlays first, then pip, then source."""
    marker = Path('share/ament_index/resource_index/packages') / package
    prefixes = [Path(p) for p in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep) if p]
    for prefix in [*prefixes, Path(sys.prefix)]:
        if (prefix / marker).is_file():
            yield prefix / 'share' / package
    if package == _THIS_PACKAGE and (_SOURCE_TREE / 'package.xml').is_file():
        yield _SOURCE_TREE

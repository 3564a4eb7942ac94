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
import site
import sysconfig
from urllib.parse import unquote

from .fields import listed
from ..errors import ModelError

_THIS_PACKAGE = 'screw_kinematics'
_SOURCE_TREE = Path(__file__).resolve().parents[2]


def local_path(uri: str) -> Path:
    """
    Return the path of the file that a ``package://`` or ``file://`` URI or a plain path names.

    Raises
    ------
    ModelError
        The scheme is another one, the package is not found, or there is no such file.

    Examples
    --------
    >>> local_path('package://screw_kinematics/config/robots/puma560.yaml').name
    'puma560.yaml'

    """
    scheme, separator, rest = uri.partition('://')
    host, _, relative = rest.partition('/')
    if not separator:
        path = os.path.expanduser(uri)
    elif scheme == 'file' and host in ('', 'localhost'):
        path = '/' + unquote(relative)
    elif scheme == 'package' and host:
        path = _package_file(uri, host, unquote(relative))
    else:
        raise ModelError(uri, 'no robot description can be read from there; allowed: '
                         'package://<package>/<path>, file:///<path>, or a path')
    if os.path.isdir(path):
        raise ModelError(uri, f'is a directory{_elsewhere(uri, path)}; allowed: a file')
    if not os.path.isfile(path):
        raise ModelError(uri, 'no such file' + _elsewhere(uri, path))
    return Path(path)


def _elsewhere(uri: str, path: str) -> str:
    """Return the path for a message that begins with what was given, unless it is that."""
    return '' if path == uri else f': {path}'


def _package_file(uri: str, package: str, relative: str) -> str:
    shares = list(_shares(package))
    for share in shares:
        path = os.path.join(share, relative)
        if os.path.isfile(path):
            return path
    if shares:
        raise ModelError(uri, f'no such file in {listed(map(str, shares))}')
    raise ModelError(uri, f'package {package!r} is not installed; looked in '
                     f'AMENT_PREFIX_PATH and in {listed(_pip_prefixes())}')


def _shares(package: str) -> Iterator[Path]:
    """Yield the share directories of a package: overlays first, then pip, then source."""
    marker = Path('share/ament_index/resource_index/packages') / package
    workspaces = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    for prefix in [*filter(None, workspaces), *_pip_prefixes()]:
        if os.path.isfile(prefix / marker):
            yield Path(prefix, 'share', package)
    if package == _THIS_PACKAGE and (_SOURCE_TREE / 'package.xml').is_file():
        yield _SOURCE_TREE


def _pip_prefixes() -> list[str]:
    """Return where pip puts data files: for all users or the environment, for this user."""
    return [sysconfig.get_path('data'), site.getuserbase()]

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Twist, acceleration, jerk and jounce of manipulators by screw theory.

The library needs NumPy only; nothing here imports ROS.
"""
from importlib import import_module, metadata
from pathlib import Path
import re
from typing import Any

from . import screws
from .chains.inverse import InverseSolver
from .chains.joint import Joint, Mimic
from .chains.serial_chain import SerialChain
from .screws import lines, se3, states
from .screws.body_state import BodyState

_ROOMS = ('errors', 'models', 'motion', 'parallel', 'recordings', 'symbolic')

__all__ = ['BodyState', 'InverseSolver', 'Joint', 'Mimic', 'SerialChain', 'lines', 'screws',
           'se3', 'states']


def __getattr__(name: str) -> Any:
    """Return a room of the library, or the version, when first asked for."""
    if name in _ROOMS:
        return import_module(f'{__name__}.{name}')
    if name == '__version__':
        manifest = Path(__file__).resolve().parents[1] / 'package.xml'
        if manifest.is_file():      # a checkout, whatever may be installed beside
            return re.findall('<version>(.*)</version>', manifest.read_text('utf-8'))[0]
        return metadata.version(__name__)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')


def __dir__() -> list[str]:
    """Return the public names, those too that are imported when first asked for."""
    return sorted([*__all__, *_ROOMS, '__version__'])

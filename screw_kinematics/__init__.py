# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Twist, acceleration, jerk and jounce of manipulators by screw theory.

The library needs NumPy only; nothing here imports ROS.
"""
from importlib import import_module
import os
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from . import screws
    from .chains.inverse import InverseSolver
    from .chains.joint import Joint, Mimic
    from .chains.serial_chain import SerialChain
    from .screws import lines, se3, states
    from .screws.body_state import BodyState

if os.environ.get('SCREW_KINEMATICS_INTERPRETED'):
    from . import core      # noqa: F401    passes over what has been compiled

_HOMES = {'BodyState': 'screws.body_state', 'InverseSolver': 'chains.inverse',
          'Joint': 'chains.joint', 'Mimic': 'chains.joint', 'SerialChain': 'chains.serial_chain'}
_MODULES = {'lines': 'screws.lines', 'se3': 'screws.se3', 'states': 'screws.states'}
_ROOMS = ('chains', 'errors', 'models', 'motion', 'parallel', 'recordings', 'screws', 'symbolic')

__all__ = ['BodyState', 'InverseSolver', 'Joint', 'Mimic', 'SerialChain', 'lines', 'screws',
           'se3', 'states']


def __getattr__(name: str) -> Any:
    """
    Return a public name, a room of the library, or the version, when first asked for.

    So the node takes over the signals before anything that takes long is imported.
    """
    if name in _HOMES:
        value = globals()[name] = getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)
        return value
    if name in _ROOMS or name in _MODULES:
        value = globals()[name] = import_module(f'{__name__}.{_MODULES.get(name, name)}')
        return value
    if name == '__version__':
        from pathlib import Path
        import re
        manifest = Path(__file__).resolve().parents[1] / 'package.xml'
        if manifest.is_file():      # a checkout, whatever may be installed beside
            return re.findall('<version>(.*)</version>', manifest.read_text('utf-8'))[0]
        from importlib import metadata      # takes as long as all else here
        return metadata.version(__name__)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')


def __dir__() -> list[str]:
    """Return the public names, those too that are imported when first asked for."""
    return sorted({*__all__, *_ROOMS, '__version__'})

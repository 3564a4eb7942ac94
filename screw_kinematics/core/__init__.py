# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The loops that must be fast: one Python text, compiled when the package is installed.

A module with a ``.pxd`` beside it is a Python file in Cython's pure Python mode, whose classes and
functions have their types of C in the ``.pxd``. ``setup.py`` translates and compiles it; where
there is no compiler the very same file runs interpreted: slower, with the same bits. The modules
know arrays, bytes and numbers; they import nothing else of the package, and leave decisions and
errors to their callers.

To add a module, put ``<name>.py`` and ``<name>.pxd`` here; ``setup.py`` finds it. It begins with::

    # cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
    # cython: initializedcheck=False
    try:
        import cython
    except ImportError:
        from . import uncompiled as cython

In a checkout build with ``python setup.py build_ext --inplace`` (or ``pip install -e .``) after
each edit: Python prefers a compiled module to the text beside it. Few modules are better than
many: each adds some 0.1 MB and seconds to the build, the first of them what they share.

Rules that keep both ways of running the same:

1. ``+ - * /``, ``sqrt`` and functions of the C library that Python's ``math`` calls too; the
   compiler may neither contract nor reorder them. Where Python raises and C does not (division by
   zero, roots of negative numbers), the text says what happens.
2. What differs (reading a number from bytes) is behind ``if cython.compiled``, in functions of a
   line.
3. Constants of a module are declared (``cython.declare``), constants from ``tables`` in the
   ``.pxd``: what is merely assigned or imported is an object. Names from ``uncompiled`` that are
   missing are added there.
4. Loops count with ``range(n)`` or ``while``; a range with a step that is no literal is an object.
5. What comes from outside (counts, lengths, indices) is checked, since nothing else is:
   ``boundscheck`` is off.
6. No function returns a memoryview by its annotation: Cython 3.0.8 makes a module of it that
   cannot be loaded.
7. Classes of the decisions in ``motion``, and of the steps in ``messages`` and ``pipeline``, have
   a ``.pxd`` too, but nothing of Cython in their text (``annotation_typing=False``): an attribute
   or local that the ``.pxd`` does not name is a Python object, slower and right; one that other
   objects of the class read needs their type there. Fields of a ``dataclass``, which has no slots
   then, stand there in their order. A module's constants that others import are not there.
8. Classes of other modules are imported by the text and by the ``.pxd`` (``cimport``), functions
   of C by the text where it is interpreted only.
"""
from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.machinery import EXTENSION_SUFFIXES, FileFinder, SOURCE_SUFFIXES, SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
import os
from pathlib import Path
import sys
from types import ModuleType
from typing import NamedTuple

INTERPRETED = 'SCREW_KINEMATICS_INTERPRETED'
"""Environment variable: builds nothing when set for a build, runs the texts when set for a run."""

SLACK = 2.0
"""Texts are outdated that are newer by more [s]; some file systems keep whole seconds only."""

if os.environ.get(INTERPRETED):
    # A finder that knows texts only, so that compiled modules beside them are passed over.
    for room in map(str, {path.parent for path in Path(__path__[0]).parent.glob('*/*.pxd')}):
        sys.path_importer_cache[room] = FileFinder(room, (SourceFileLoader, SOURCE_SUFFIXES))


class Build(NamedTuple):
    """How the modules of this room run; as text, one line for a log."""

    interpreted: tuple[str, ...]    # modules that run as texts
    outdated: tuple[str, ...]       # those compiled from an older text than lies beside them

    @property
    def state(self) -> str:
        """Return 'compiled', 'interpreted' or 'outdated'."""
        return 'outdated' if self.outdated else 'interpreted' if self.interpreted else 'compiled'

    @property
    def compiled(self) -> bool:
        """Return whether all modules are compiled, and from the present texts."""
        return self.state == 'compiled'

    @property
    def advice(self) -> str:
        """Return what to do about it, if anything."""
        if self.outdated:
            return f'{", ".join(self.outdated)} changed since compiled: install the package again'
        if not self.interpreted:
            return ''
        if os.environ.get(INTERPRETED):
            return f'{INTERPRETED} is set'
        return ('right, but up to a hundred times slower: install a C compiler and python3-dev, '
                'then the package again')

    def __str__(self) -> str:
        return f'the core is {self.state}{self.advice and f" ({self.advice})"}'


def build() -> Build:
    """Return how the modules that are compiled run, from the files that are there."""
    interpreted, outdated = [], []
    for text in texts():
        name = f'{text.parent.name}.{text.stem}'
        binaries = [] if os.environ.get(INTERPRETED) else [
            path for path in map(text.with_suffix, EXTENSION_SUFFIXES) if path.exists()]
        if not binaries:
            interpreted.append(name)
        elif any(source.exists() and source.stat().st_mtime
                 > binaries[0].resolve().stat().st_mtime + SLACK
                 for source in (text, text.with_suffix('.pxd'))):
            outdated.append(name)
    return Build(tuple(interpreted), tuple(outdated))


@cache
def interpreted(name: str) -> ModuleType:
    """Return a module of this room as its text, whatever has been compiled."""
    text = Path(__file__).with_name(f'{name}.py')
    full_name = f'{__name__}.{name}'
    module = import_module(full_name)
    if module.__file__ == str(text):
        return module
    spec = spec_from_file_location(full_name, text)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def texts() -> list[Path]:
    """Return the files of the package that are compiled: those with types beside them."""
    package = Path(__file__).parents[1]
    return sorted(path.with_suffix('.py') for path in package.glob('*/*.pxd'))

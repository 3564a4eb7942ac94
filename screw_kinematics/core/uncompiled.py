# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the texts of the core need of ``cython`` while they are interpreted.

Used where Cython is not installed; compiled modules need nothing. Types stand in annotations
alone, which are never evaluated.
"""
from __future__ import annotations

from contextlib import nullcontext
from typing import Any

compiled = False
double = int = longlong = ulonglong = uint = bint = Py_ssize_t = None


def _same(function: Any) -> Any:
    return function


class _NoGil(nullcontext):
    """Both a context and a decorator."""

    def __call__(self, function: Any) -> Any:
        return function


nogil = _NoGil()
cclass = cfunc = ccall = inline = final = _same


def boundscheck(_: bool) -> Any:
    """Return a decorator that changes nothing."""
    return _same


def declare(_: Any, value: Any) -> Any:
    """Return the value of a constant."""
    return value


def cast(_: Any, value: Any) -> Any:
    """Return the value."""
    return value


def exceptval(*_: Any, **__: Any) -> Any:
    """Return a decorator that changes nothing."""
    return _same

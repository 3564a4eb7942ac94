# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Checked reading of a description's fields; errors name place, key, value, allowed."""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import SequenceMatcher
import math
import reprlib
from typing import Any

from ..errors import ModelError, ScrewKinematicsError

MAX_TEXT = 200  # characters of a name, so that messages stay readable
_SHOWN = 12     # names listed in a message before it says how many more there are
_ALIKE = 0.6    # of SequenceMatcher's ratio: as in difflib
_short = reprlib.Repr()
_short.maxstring = _short.maxother = 80


def shown(value: Any) -> str:
    """
    Return a value for a message, never much longer than a line.

    Examples
    --------
    >>> shown('no number')
    "'no number'"

    """
    return _short.repr(value)


def listed(names: Iterable[str], near: str = '') -> str:
    """
    Return names for a message, quoted, at most a dozen, those that look like a given one first.

    Examples
    --------
    >>> listed(['base', 'tool'])
    "'base', 'tool'"
    >>> listed(['base', 'tool'], near='Tol')
    "'tool', 'base'"

    """
    names = list(names)
    if near:
        names = list(dict.fromkeys([*nearest(near, names), *names]))
    text = ', '.join(shown(name) for name in names[:_SHOWN]) or 'none'
    return text if len(names) <= _SHOWN else f'{text} and {len(names) - _SHOWN} more'


def nearest(given: str, names: Iterable[str]) -> list[str]:
    """
    Return the names that look like one that was given, the most alike first.

    Case does not count, and a name with a prefix or suffix is near the name itself.

    Examples
    --------
    >>> nearest('flang', ['link_01', 'flange', 'left_flange'])
    ['flange', 'left_flange']

    """
    given = given.lower()[:MAX_TEXT]
    matcher = SequenceMatcher(b=given)
    found = []
    for name in names:
        lower = name.lower()
        matcher.set_seq1(lower)
        if matcher.real_quick_ratio() < _ALIKE and given not in lower:
            continue
        alike = matcher.quick_ratio()
        alike = matcher.ratio() if alike >= _ALIKE else 0.0
        if given and (given in lower or lower in given):
            alike = max(alike, _ALIKE)
        if alike >= _ALIKE:
            found.append((-alike, name))
    return [name for _, name in sorted(found)]


def number(value: Any) -> float | None:
    """
    Return a finite float, or None where the value is not one.

    Text is accepted, since XML and guarded YAML have nothing else; symbols are left alone.

    Examples
    --------
    >>> number('1e-3'), number('nan'), number(True)
    (0.001, None, None)

    """
    if hasattr(value, 'free_symbols'):
        return value    # type: ignore[no-any-return]
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return None
    if isinstance(value, str) and '_' in value:     # Python reads 1_000, XML does not
        return None
    try:
        result = float(value)
    except (ValueError, OverflowError):
        return None
    return result if math.isfinite(result) else None


@contextmanager
def reported(source: str) -> Iterator[None]:
    """Add the source to errors of joints and chains built from it."""
    try:
        yield
    except ModelError:
        raise
    except ScrewKinematicsError as error:
        raise ModelError(source, str(error)) from error


class Fields:
    """
    The fields of one part of a description; all methods raise ModelError.

    The place says which part of the source this is, for instance ``joint 'q1'``. A key that is not
    known is refused; if none is named, all are known.
    """

    def __init__(self, source: str, place: str, values: Any,
                 known: Sequence[str] | None = None) -> None:
        self.source, self.place = source, place
        if not isinstance(values, Mapping):
            raise self.wrong(values, f'keys with values ({listed(known or ())})')
        self._values = values
        for key in values:
            if known is not None and key not in known:
                raise self.error(f'unknown key {shown(key)}; allowed: {listed(known)}')

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def error(self, problem: str) -> ModelError:
        """Return the error for a problem at this place."""
        return ModelError(self.source, f'{self.place}: {problem}' if self.place else problem)

    def wrong(self, value: Any, allowed: str, key: str = '') -> ModelError:
        """Return the error for a value that is not allowed."""
        label = f'{key}: ' if key else ''
        return self.error(f'{label}got {shown(value)}; allowed: {allowed}')

    def raw(self, key: str, default: Any = None) -> Any:
        """Return the value as read."""
        return self._values.get(key, default)

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text of bounded length; required unless there is a default."""
        value = self.raw(key, default)
        # Messages carry names as UTF-8 that ends in NUL, so not every character may come in.
        if not isinstance(value, str) or not value.strip() or not value.isprintable() or (
                len(value) > MAX_TEXT):
            raise self.wrong(value, f'text of 1 to {MAX_TEXT} printable characters', key)
        return value

    def choice(self, key: str, options: Iterable[str], default: str | None = None) -> str:
        """Return one of the options; required unless there is a default."""
        value = self.raw(key, default)
        options = tuple(options)
        if not isinstance(value, str) or value not in options:
            raise self.wrong(value, listed(options), key)
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """Return a finite number; required unless there is a default."""
        value = self.raw(key, default)
        result = number(value)
        if result is None:
            raise self.wrong(value, 'a finite number', key)
        return result

    def numbers(self, key: str, count: int,
                default: Sequence[float] | None = None) -> list[float]:
        """Return finite numbers, from a sequence or from text with blanks between."""
        value = self.raw(key, default)
        parts = value.split() if isinstance(value, str) else value
        if isinstance(parts, Sequence) and len(parts) == count:
            result = [x for x in map(number, parts) if x is not None]
            if len(result) == count:
                return result
        raise self.wrong(value, f'{count} finite numbers', key)

    def items(self, key: str, most: int) -> Sequence[Any]:
        """Return a list of one to ``most`` entries."""
        value = self.raw(key)
        if not isinstance(value, list) or not 1 <= len(value) <= most:
            raise self.wrong(value, f'a list of 1 to {most} entries', key)
        return value

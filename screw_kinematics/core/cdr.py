# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
"""
Numbers out of serialized joint states, and into serialized stamped messages.

Plain little-endian CDR, on machines that are little-endian themselves. Where things are is found
by :mod:`screw_kinematics.messages`; here every place is checked to be inside of the message, and
every count in a message to be the one that the places were found with.
"""
from __future__ import annotations

from array import array
from struct import pack_into, unpack_from

try:
    import cython
except ImportError:
    from . import uncompiled as cython
if cython.compiled:
    from cython.cimports.cpython.bytes import PyBytes_FromStringAndSize
    from cython.cimports.cpython.float import PyFloat_FromDouble
    from cython.cimports.cpython.ref import Py_INCREF
    from cython.cimports.cpython.tuple import PyTuple_New, PyTuple_SET_ITEM
    from cython.cimports.libc.string import memcmp, memcpy

_SECOND = cython.declare(cython.longlong, 1000000000)    # ns
_STAMP = cython.declare(cython.Py_ssize_t, 4)            # start of the stamp
_LARGEST = cython.declare(cython.longlong, 1 << 31)        # s, signed in the message
_HEAD = cython.declare(cython.Py_ssize_t, 12)            # its end: start of what stays the same


def _count(data: bytes, at: cython.Py_ssize_t) -> cython.uint:
    """Return the unsigned number of four bytes at a place."""
    number: cython.uint = 0
    if cython.compiled:
        memcpy(cython.address(number), cython.cast(cython.p_char, data) + at, 4)
    else:
        number, = unpack_from('<I', data, at)
    return number


def _reals(data: bytes, at: cython.Py_ssize_t, count: cython.Py_ssize_t) -> tuple:
    """Return so many floats at a place."""
    if cython.compiled:
        i: cython.Py_ssize_t
        number: cython.double = 0.0
        source: cython.p_char = cython.cast(cython.p_char, data) + at
        results: tuple = PyTuple_New(count)
        for i in range(count):
            memcpy(cython.address(number), source + 8 * i, 8)
            x: object = PyFloat_FromDouble(number)
            Py_INCREF(x)        # the tuple takes a reference
            PyTuple_SET_ITEM(results, i, x)
        return results
    else:
        return unpack_from(f'<{count}d', data, at)


class JointStateLayout:
    """
    Where things are in all joint states that differ from an example in stamp and numbers only.

    The mask, as long as the example, is 0 where bytes have no defined value. The part from the end
    of the stamp to ``end`` stays the same. Positions and velocities are so many, and begin at
    their places; ``velocity_count_at`` and ``effort_count_at`` are the places of the counts after
    them.

    Raises
    ------
    ValueError
        A place is not inside of the example.

    """

    def __init__(self, example: bytes, mask: bytes, end: int, position_at: int, positions: int,
                 velocity_count_at: int, velocity_at: int, velocities: int,
                 effort_count_at: int) -> None:
        size = len(example)
        if not (len(mask) == size and 12 <= end <= size
                and 0 <= positions <= size and 0 <= position_at <= size - 8 * positions
                and 0 <= velocities <= size and 0 <= velocity_at <= size - 8 * velocities
                and 0 <= velocity_count_at <= size - 4 and 0 <= effort_count_at <= size - 4):
            raise ValueError('a layout that reaches beyond its message')
        self.example, self.mask, self.size, self.end = example, mask, size, end
        self.position_at, self.positions = position_at, positions
        self.velocity_at, self.velocities = velocity_at, velocities
        self.velocity_count_at, self.effort_count_at = velocity_count_at, effort_count_at

    def read(self, data: bytes) -> tuple | None:
        """Return stamp [ns], positions and velocities; None of a message that differs more."""
        if len(data) != self.size or not self.fits(data):
            return None
        nanoseconds: cython.longlong = _count(data, _STAMP + 4)
        if nanoseconds >= _SECOND:
            return None
        seconds: cython.longlong = _count(data, _STAMP)
        if seconds >= _LARGEST:
            seconds -= 2 * _LARGEST
        return (seconds * _SECOND + nanoseconds, _reals(data, self.position_at, self.positions),
                _reals(data, self.velocity_at, self.velocities))

    def fits(self, data: bytes) -> bool:
        """Return whether a message, as long as the example, has the same names and counts."""
        i: cython.Py_ssize_t
        if (_count(data, self.velocity_count_at) != self.velocities
                or _count(data, self.effort_count_at)
                != _count(self.example, self.effort_count_at)):
            return False
        if cython.compiled:
            a: cython.p_uchar = cython.cast(cython.p_uchar, data)
            b: cython.p_uchar = cython.cast(cython.p_uchar, self.example)
            mask: cython.p_uchar = cython.cast(cython.p_uchar, self.mask)
            if a[0] != b[0] or a[1] != b[1]:
                return False
            if memcmp(a + _HEAD, b + _HEAD, self.end - _HEAD) == 0:
                return True
            for i in range(_HEAD, self.end):
                if (a[i] ^ b[i]) & mask[i]:
                    return False
            return True
        else:
            if data[:2] != self.example[:2]:
                return False
            return data[12:self.end] == self.example[12:self.end] or not any(
                (x ^ y) & m for x, y, m in zip(data[12:self.end], self.example[12:self.end],
                                               self.mask[12:self.end]))


class StampedMessage:
    """
    A message of a stamp, things that stay the same, and numbers.

    Of the example the stamp, bytes 4 to 12, and the numbers are replaced. Places say where each
    number is, the order which of the values it is.

    Raises
    ------
    ValueError
        The example has no stamp, a place is not inside of it, or the order is negative.

    """

    def __init__(self, example: bytes, places: list, order: list) -> None:
        if len(places) != len(order) or min(order, default=0) < 0:
            raise ValueError('each number has a place in the message, and one among the values')
        if len(example) < 12 or not all(12 <= place <= len(example) - 8 for place in places):
            raise ValueError('a message without a stamp, or numbers that reach beyond it')
        self.example, self.count, self.needed = example, len(order), max(order, default=-1) + 1
        self.places, self.order = memoryview(array('q', [*places, 0])), memoryview(
            array('q', [*order, 0]))

    @cython.boundscheck(True)
    def write(self, stamp_ns: cython.longlong, values: object) -> bytes | None:
        """
        Return the message; None of a stamp that does not fit.

        Raise ValueError if there are fewer values than the message has numbers.
        """
        i: cython.Py_ssize_t
        if not -_LARGEST * _SECOND <= stamp_ns < _LARGEST * _SECOND:
            return None
        if len(values) < self.needed:
            raise ValueError(f'{self.needed} values are needed, not {len(values)}')
        seconds: cython.longlong = stamp_ns // _SECOND
        nanoseconds: cython.longlong = stamp_ns - seconds * _SECOND
        if nanoseconds < 0:        # C rounds towards zero
            seconds, nanoseconds = seconds - 1, nanoseconds + _SECOND
        if cython.compiled:
            size: cython.Py_ssize_t = len(self.example)
            stamp = cython.declare(cython.int[2])
            number: cython.double = 0.0
            message: bytes = PyBytes_FromStringAndSize(cython.NULL, size)
            target: cython.p_char = cython.cast(cython.p_char, message)
            memcpy(target, cython.cast(cython.p_char, self.example), size)
            stamp[0], stamp[1] = seconds, nanoseconds
            memcpy(target + _STAMP, stamp, 8)
            for i in range(self.count):
                number = values[self.order[i]]
                memcpy(target + self.places[i], cython.address(number), 8)
            return message
        else:
            body = bytearray(self.example)
            pack_into('<iI', body, _STAMP, seconds, nanoseconds)
            for i in range(self.count):
                pack_into('<d', body, self.places[i], values[self.order[i]])
            return bytes(body)

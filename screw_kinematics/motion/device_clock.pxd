# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from .held_readings cimport HeldReadings
from .tick_counter cimport TickCounter
from ..core.bank cimport Bank
from ..core.period_search cimport PeriodSearch
from ..core.readings cimport Readings

cdef double JITTER, ADOPT, REGULAR, NOTHING, LONG, NEXT
cdef long WINDOW, FAR, FEW_TICKS


@cython.final
cdef class Placed:
    cdef readonly object time, replay
    cdef readonly double instant, rate, age


@cython.final
cdef class DeviceClock:
    cdef dict __dict__
    cdef public TickCounter ticks
    cdef public double unit, share
    cdef public bint proven
    cdef public long held, fresh, lost
    cdef Readings _readings
    cdef PeriodSearch _periods
    cdef HeldReadings _repeated
    cdef object _begun, _shares, _position, _foreseen
    cdef double _first, _last, _time, _tick, _deviation, _ahead, _ratio, _patience, _wait
    cdef double _wrong, _heard, _messages, _spacing, _doubt
    cdef long _new, _rest, _told, _contrary
    cdef bint _lossy

    cpdef start(self, double stamp, object position, DeviceClock known=*)
    @cython.locals(
        same=bint, ticks=TickCounter, period=double, unit=double, x=double, foreseen=double,
        unforeseen=double, length=double, usual=double, near=long, span=double, told=bint,
        age=double, d=long, off=double, step=double, agree=bint, before=bint, late=double,
        steps=double, most=double, regular=bint, paced=bint, pause=bint, by_joints=bint,
        onward=double)
    cpdef Placed update(self, double stamp, object position, Bank bank)
    @cython.locals(age=double)
    cdef Placed _begin(self, double stamp, object position, bint same)

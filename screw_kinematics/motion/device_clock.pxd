# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython

from libc.math cimport lrint as round       # as Python does: halves to even

from .foresight cimport Foreseen, Foresight
from .held_readings cimport HeldReadings
from .joint_evidence cimport JointEvidence
from .tick_counter cimport TickCounter
from ..core.bank cimport Bank

cdef double STRETCH, JITTER, TOLD, REGULAR, NOTHING, VOTE
cdef long MANY


@cython.final
cdef class Placed:
    cdef readonly object time, replay
    cdef readonly double instant, rate, age
    cdef readonly bint anew


@cython.final
cdef class DeviceClock:
    cdef dict __dict__
    cdef public TickCounter ticks
    cdef public double unit, share
    cdef public bint proven
    cdef public long held, fresh, lost
    cdef JointEvidence _evidence
    cdef Foresight _foresight
    cdef HeldReadings _repeated
    cdef object _begun, _position
    cdef double _first, _last, _time, _ahead, _ratio
    cdef double _wrong, _true, _heard, _messages, _before, _spacing, _doubt
    cdef long _told, _contrary
    cdef bint _lossy

    cpdef start(self, double stamp, object position, DeviceClock known=*)
    @cython.locals(same=bint, ticks=TickCounter, near=long, foreseen=Foreseen, d=long,
                   regular=bint, pause=bint)
    cpdef Placed update(self, double stamp, object position, Bank bank)
    @cython.locals(steps=double, since=double, messages=double, over=bint)
    cdef _hear(self, double stamp)
    @cython.locals(age=double)
    cdef Placed _begin(self, double stamp, object position, bint same, bint anew=*)
    @cython.locals(age=double, repeats=double)
    cdef long _count(self, TickCounter ticks, double stamp, bint same, Foreseen foreseen,
                     Bank bank) except -1
    cdef bint _regular(self, TickCounter ticks) noexcept
    @cython.locals(age=double)
    cdef bint _pauses(self, TickCounter ticks, double stamp, Foreseen foreseen) noexcept
    @cython.locals(age=double)
    cdef Placed _hold(self, TickCounter ticks, double stamp)
    cdef Placed _stand(self, TickCounter ticks, double stamp, object position, long d)
    @cython.locals(period=double, unit=double, age=double, step=double, span=double, most=double,
                   agree=bint, right=bint, onward=double, late=double, off=double)
    cdef _place(self, TickCounter ticks, double stamp, object position, bint same, long d,
                bint by_stamps, Foreseen foreseen)
    @cython.locals(vague=bint)
    cdef double _advance(self, TickCounter ticks, double stamp, long d, bint agree,
                         Foreseen foreseen) except? -1e300
    @cython.locals(ticks=TickCounter, held=bint)
    cdef object _ask_joints(self)
    @cython.locals(ticks=TickCounter)
    cdef object _recount(self)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
cimport cython


@cython.final
cdef class Fading:
    # Over 0.03, 0.1, 1 and 2 s; of a misfit that grows, 0.2 s, and one that falls, 5 s.
    cdef double brief, lasting, second, seconds
    cdef double near, slow

    cdef void after(self, double dt) noexcept


@cython.final
cdef class VelocityTrust:
    cdef double position, latest    # latest sample; samples in a row
    cdef double count
    # Integrals over MEMORY of (velocity less position step), of the velocity's change, of the
    # velocity; the same over 0.1 s; their regression.
    cdef double wrong, change, way
    cdef double wrong_long, change_long, way_long
    cdef double wc, cc, wx, xx, xc
    cdef readonly double lag, scale     # lag, share of scale
    # Mean squares of what lag and scale leave, of (velocity times step less position step), of
    # the same less what the acceleration adds, of the position's noise; samples they are of.
    cdef double left, back, true, noise
    cdef double seen
    cdef double misfit              # of both accelerations
    cdef readonly double alive      # samples that were not zero
    cdef double missing             # samples missing
    cdef readonly double share      # the weight of the velocity in the latest output

    cdef void await_sample(self) noexcept
    cdef double parted(self, double z, double v, double dt) noexcept
    cdef void compare(self, double z, double v, double dt, Fading keep, double acceleration,
                      double noise, bint settling) noexcept
    cdef void discount(self, double share) noexcept
    cpdef bint differenced(self) noexcept
    cdef bint usable(self) noexcept
    cdef double speed(self, double foreseen, double acceleration) noexcept
    cdef double weigh(self, double off, double wider, double sp, double sv, Fading keep,
                      bint fresh) noexcept

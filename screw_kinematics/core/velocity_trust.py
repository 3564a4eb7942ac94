# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a measured velocity is what it claims, by the positions that come with it."""
from __future__ import annotations

try:
    import cython
except ImportError:
    from . import uncompiled as cython
if cython.compiled:
    from cython.cimports.libc.math import exp, isfinite
else:
    from math import exp, isfinite

MEMORY = cython.declare(cython.double, 0.03)
"""Of the integral of velocity less position step, s."""

WORST = cython.declare(cython.double, (2 * 3.141592653589793 * 20.0 * 0.03) ** 4)
"""By the highest frequency at which that is trusted to show a wrong acceleration, 20 Hz."""

MARGIN = cython.declare(cython.double, 1.25)
TOLERATED = cython.declare(cython.double, 2.0)
EARLY_LAG = cython.declare(cython.double, 1e-3)
LATE_LAG = cython.declare(cython.double, 5e-3)
"""Lag from which on a velocity is doubted, and how much more until it counts nothing, s."""

FAMILIAR = cython.declare(cython.double, 100.0)
RIGHT = cython.declare(cython.double, 0.05)
"""Samples from which on a velocity may tell how far its joint went, and by what share of it it may
be too large."""

QUIETER = cython.declare(cython.double, 1e-2)
LITTLE = cython.declare(cython.double, 1e-10)
"""Share of their noise's variance to which positions fall that are of another kind: a second
publisher has gone, a sensor has settled; and what is too little to tell kinds apart [rad^2]."""

UNKNOWN = cython.declare(cython.double, 1e300)


class Fading:
    """What is left of sums over several memories after a step: of all joints alike."""

    def __init__(self) -> None:
        self.after(0.0)

    def after(self, dt: cython.double) -> None:
        """Take a step [s]."""
        self.brief, self.lasting = exp(-dt / MEMORY), exp(-dt / 0.1)
        self.second, self.seconds = exp(-dt), exp(-dt / 2.0)
        self.near, self.slow = exp(-dt / 0.2), exp(-dt / 5.0)


class VelocityTrust:
    """What is known of the velocity of one joint."""

    def __init__(self) -> None:
        self.position = self.latest = self.count = self.wrong = self.change = self.way = 0.0
        self.wrong_long = self.change_long = self.way_long = 0.0
        self.wc = self.cc = self.wx = self.xx = self.xc = self.lag = self.scale = 0.0
        self.left = self.back = self.true = self.noise = self.seen = self.misfit = 0.0
        self.alive = self.missing = self.share = 0.0

    def await_sample(self) -> None:
        """Compare the next sample with none before it."""
        self.count = 0.0

    def parted(self, z: cython.double, v: cython.double, dt: cython.double) -> cython.double:
        """Return the velocity's way since the latest sample less the position's step."""
        if self.count > 0.0 and isfinite(v):
            return 0.5 * (v + self.latest) * dt - (z - self.position)
        return UNKNOWN

    def compare(self, z: cython.double, v: cython.double, dt: cython.double, keep: Fading,
                acceleration: cython.double, noise: cython.double,
                settling: cython.bint) -> None:
        """
        Compare a velocity with its position.

        Lag and scale by regression of the leaky integral of (velocity less position step) on
        those of the velocity's change and of the velocity.
        """
        if not isfinite(v):
            self.await_sample()
            self.missing += 1.0
            return
        self.missing = 0.0
        quiet: cython.double = noise if noise > LITTLE else LITTLE
        if quiet < QUIETER * self.noise:
            self.discount(quiet / self.noise)
        if v != 0.0:
            self.alive += 1.0
        if self.count > 0.0:
            step: cython.double = z - self.position
            way: cython.double = 0.5 * (v + self.latest) * dt
            wrong: cython.double = way - step
            change: cython.double = v - self.latest
            self.wrong = keep.brief * self.wrong + wrong
            self.change = keep.brief * self.change + change
            self.way = keep.brief * self.way + way
            left: cython.double = self.wrong + self.lag * self.change - self.scale * self.way
            back: cython.double = v * dt - step
            k: cython.double = 1.0 - keep.second
            if not settling:
                self.seen += 1.0
                first: cython.double = 1.0 / self.seen
                k = k if k > first else first
            self.back += k * (back * back - self.back)
            # A velocity of the step's end leaves half of what the acceleration adds to it.
            back -= 0.5 * acceleration * dt * dt
            self.true += k * (back * back - self.true)
            self.left += k * (left * left - self.left)
            self.noise += k * (noise - self.noise)
            k = keep.lasting
            b: cython.double = k * self.wrong_long + wrong
            c: cython.double = k * self.change_long + change
            x: cython.double = k * self.way_long + way
            self.wrong_long, self.change_long, self.way_long = b, c, x
            if self.count > 10.0:
                k = keep.seconds
                self.wc = k * self.wc - b * c * dt
                self.cc = k * self.cc + c * c * dt
                self.wx = k * self.wx + b * x * dt
                self.xx = k * self.xx + x * x * dt
                self.xc = k * self.xc - x * c * dt
                cc: cython.double = self.cc + 1e-9
                xx: cython.double = self.xx + 1e-7
                det: cython.double = cc * xx - self.xc * self.xc
                lag: cython.double = (self.wc * xx - self.wx * self.xc) / det
                lag = lag if lag > 0.0 else 0.0
                self.lag = lag if lag < 0.05 else 0.05
                scale: cython.double = (self.wx - self.lag * self.xc) / xx
                scale = scale if scale > -0.1 else -0.1
                self.scale = scale if scale < 0.1 else 0.1
        self.position, self.latest = z, v
        self.count += 1.0

    def discount(self, share: cython.double) -> None:
        """Let all that was learnt so far count so much less."""
        self.wc *= share
        self.cc *= share
        self.wx *= share
        self.xx *= share
        self.xc *= share
        self.left *= share
        self.back *= share
        self.true *= share
        self.noise *= share

    def differenced(self) -> cython.bint:
        """Whether it is merely the last step over its time, as far as noise can tell."""
        return self.back < 0.01 * self.noise and self.back < self.true

    def usable(self) -> cython.bint:
        """Whether it may count at all."""
        return self.alive >= 10.0 and self.missing <= 2.0 and not self.differenced()

    def speed(self, foreseen: cython.double, acceleration: cython.double) -> cython.double:
        """Return the velocity at the latest sample: the measured one if it is right, of late."""
        if (self.seen > FAMILIAR and self.count > 0.0 and self.usable() and self.lag < LATE_LAG
                and -RIGHT < self.scale < RIGHT):
            return (self.latest + self.lag * acceleration) / (1.0 + self.scale)
        return foreseen

    def weigh(self, off: cython.double, wider: cython.double, sp: cython.double,
              sv: cython.double, keep: Fading, fresh: cython.bint) -> cython.double:
        """
        Return the weight of the velocity's acceleration beside the position's.

        Its variance is raised by what shows that it is not what it claims: misfit of both
        accelerations, by at most what the integral could hide; a lag beyond a millisecond; the
        way to wider filters, if it leads to the position's acceleration: it is behind a jump.

        ``off`` is how far it is from the position's, ``wider`` how far its wider filters are from
        it; ``sp`` and ``sv`` are variances of the position's and the velocity's acceleration.
        ``keep`` is what the latest step leaves, and ``fresh`` whether this was not asked since.
        """
        apart: cython.double = off * off
        d: cython.double = apart / (sp + sv)
        d = d if d < 50.0 else 50.0
        if fresh:
            near: cython.double = d + keep.near * (self.misfit - d)
            slow: cython.double = self.misfit * keep.slow
            self.misfit = near if d >= self.misfit or near > slow else slow
        excess: cython.double = self.misfit - TOLERATED
        excess = excess * excess * (sp + sv) if excess > 0.0 else 0.0
        hidden: cython.double = self.left - MARGIN * self.noise
        hidden = WORST * hidden / (MEMORY * MEMORY * MEMORY * MEMORY) if hidden > 0.0 else 0.0
        late: cython.double = (self.lag - EARLY_LAG) / LATE_LAG
        late = 0.0 if late < 0.0 else late if late < 1.0 else 1.0
        behind: cython.double = -off * wider
        behind = 0.0 if behind < 0.0 else behind if behind < apart else apart
        sv += (excess if excess < hidden else hidden) + late * apart + behind
        self.share = sp / (sp + sv)
        return self.share

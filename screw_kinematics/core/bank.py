# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# cython: initializedcheck=False
# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Integrated-Wiener Kalman filters of many bandwidths for each joint, weighed by likelihood.

The same bank twice: one for positions and, with the same gains, one for velocities. Covariances
are in units of the unknown variance of a joint's noise, so that gains, covariances and weights of
the fixed-lag smoother depend on the times alone and are shared by all joints and both banks.

Memory: M filters, n joints; lane = joint * M + filter. Tables have one row for each quantity and
one column for each lane, so that inner loops run through memory in order. Symmetric matrices are
their upper triangles, 10 rows. States are scaled: component i times TIME_UNIT**i / i!.
"""

from __future__ import annotations

from array import array
from typing import Any

try:
    import cython
except ImportError:
    from . import uncompiled as cython
if cython.compiled:
    from cython.cimports.libc.math import exp, fabs, floor, isfinite, log, sqrt
else:
    from math import exp, fabs, floor, isfinite, log, sqrt

TIME_UNIT = cython.declare(cython.double, 0.02)

# Scores: memory of the innovations [s], what a score is worth as evidence (noise is coloured), and
# the deviation, in deviations foreseen, beyond which a sample waits for the next one.
WINDOW = cython.declare(cython.double, 0.1)
EVIDENCE = cython.declare(cython.double, 0.65)
HOLD = cython.declare(cython.double, 6.0)
SPARSE = cython.declare(cython.double, 0.01)    # period at which a handicap counts once [s],
DENSEST = cython.declare(cython.double, 8.0)    # and by how much it may be shorter
LEAST = cython.declare(cython.double, 1e-26)
NEGLIGIBLE = cython.declare(cython.double, 1e-4)     # weights below are passed over

# A jump that this acceleration [rad/s2] explains need not wait, where samples are this far apart.
NAN = cython.declare(cython.double, float('nan'))
PLAUSIBLE = cython.declare(cython.double, 220.0)
SLOW = cython.declare(cython.double, 3e-3)
LONGEST_WAIT = cython.declare(cython.int, 3)
FIRST_WAIT = cython.declare(cython.int, 12)

# Velocities: memory of the integral of velocity less position step [s], the highest frequency at
# which it is trusted to show a wrong acceleration [Hz], and from which lag on [s] it is doubted.
MEMORY = cython.declare(cython.double, 0.03)
WORST = cython.declare(cython.double, (2 * 3.141592653589793 * 20.0 * 0.03) ** 4)
MARGIN = cython.declare(cython.double, 1.25)
TOLERATED = cython.declare(cython.double, 2.0)
EARLY_LAG = cython.declare(cython.double, 1e-3)
LATE_LAG = cython.declare(cython.double, 5e-3)

# Numbers of a joint in a bank: latest sample; the encoder's step, share of changes that are
# multiples of it, their number; deviation of the sample that waits, samples that wait, usual
# deviation, noise, number of odd samples, limit when the first came, whether it was taken; the
# state without it; the step before it.
LAST = cython.declare(cython.int, 0)
QUANTUM = cython.declare(cython.int, 1)
FIT = cython.declare(cython.int, 2)
CHANGES = cython.declare(cython.int, 3)
PENDING = cython.declare(cython.int, 4)
WAITING = cython.declare(cython.int, 5)
ENVELOPE = cython.declare(cython.int, 6)
NOISE = cython.declare(cython.int, 7)
ODD = cython.declare(cython.int, 8)
LIMIT = cython.declare(cython.int, 9)
TAKEN = cython.declare(cython.int, 10)
WITHOUT = cython.declare(cython.int, 11)
STEP = cython.declare(cython.int, 15)
NUMBERS = cython.declare(cython.int, 16)

# Numbers of a joint's velocity: latest position and velocity, samples; integrals over MEMORY of
# (velocity less position step), of the velocity's change, of the velocity; the same over 0.1 s;
# their regression; lag, share of scale; mean square of what lag and scale leave, of (velocity
# times step less position step), of the position's noise; misfit of both accelerations; samples
# that were not zero, samples missing; the weight of the velocity in the latest output.
V_POSITION = cython.declare(cython.int, 0)
V_LATEST = cython.declare(cython.int, 1)
V_COUNT = cython.declare(cython.int, 2)
V_WRONG = cython.declare(cython.int, 3)
V_CHANGE = cython.declare(cython.int, 4)
V_WAY = cython.declare(cython.int, 5)
V_WRONG_LONG = cython.declare(cython.int, 6)
V_CHANGE_LONG = cython.declare(cython.int, 7)
V_WAY_LONG = cython.declare(cython.int, 8)
V_WC = cython.declare(cython.int, 9)
V_CC = cython.declare(cython.int, 10)
V_WX = cython.declare(cython.int, 11)
V_XX = cython.declare(cython.int, 12)
V_XC = cython.declare(cython.int, 13)
V_LAG = cython.declare(cython.int, 14)
V_SCALE = cython.declare(cython.int, 15)
V_LEFT = cython.declare(cython.int, 16)
V_DIFFERENCED = cython.declare(cython.int, 17)
V_NOISE = cython.declare(cython.int, 18)
V_MISFIT = cython.declare(cython.int, 19)
V_ALIVE = cython.declare(cython.int, 20)
V_MISSING = cython.declare(cython.int, 21)
V_SHARE = cython.declare(cython.int, 22)
V_TRUE = cython.declare(cython.int, 23)
V_SEEN = cython.declare(cython.int, 24)
V_NUMBERS = cython.declare(cython.int, 25)

# What `read` answers.
READ = cython.declare(cython.int, 0)
TOO_EARLY = cython.declare(cython.int, 1)
TOO_LONG_AGO = cython.declare(cython.int, 2)

LARGEST_RING = 4096
SCALE = (1.0, TIME_UNIT, TIME_UNIT**2 / 2.0, TIME_UNIT**3 / 6.0)
FACTORIAL = (1.0, 1.0, 2.0, 6.0)
PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]     # rows of a triangle
PRIOR = (1.0, 2e5, 1.5e6, 3e7)      # deviations of the state, in units of the noise, per s ...


def table(rows: int, columns: int) -> Any:
    """Return a table of zeros."""
    return memoryview(array('d', bytes(8 * max(rows, 1) * max(columns, 1)))).cast('B').cast(
        'd', (max(rows, 1), max(columns, 1)))


def row(values: Any) -> Any:
    """Return numbers in a row."""
    return memoryview(array('d', values))


def moved(old: Any, size: int, room: int, columns: int, first: int, last: int) -> Any:
    """Return a ring of `room` rows with the steps from the first to the last of a smaller one."""
    new = table(room, columns)
    for step in range(first, last + 1):
        for k in range(columns):
            new[step % room, k] = old[step % size, k]
    return new


def zeros(count: int) -> Any:
    """Return zeros in a row."""
    return memoryview(array('d', bytes(8 * count)))


@cython.cclass
class Channel:
    """What the bank keeps of positions, or of velocities."""

    x: cython.double[:, ::1]          # scaled states, (4, n M)
    mean: cython.double[::1]          # forgetful mean squares of the innovations over variances
    before: cython.double[::1]        # the same before the sample that waits
    weight: cython.double[::1]
    joint: cython.double[:, ::1]      # (n, NUMBERS)
    states: cython.double[:, ::1]     # predicted states of the latest steps, (steps, 4 n M)
    errors: cython.double[:, ::1]     # innovations of the latest steps, (steps, n M)

    def __init__(self, n: int, m: int) -> None:
        self.x = table(4, n * m)
        self.mean, self.before, self.weight = zeros(n * m), zeros(n * m), zeros(n * m)
        self.joint = table(n, NUMBERS)
        self.states, self.errors = table(1, 1), table(1, 1)


@cython.cclass
class Bank:
    """
    A bank for n joints; see the module.

    Parameters
    ----------
    n:
        Number of joints.
    bandwidths:
        (order of the model, bandwidth in Hz) of each filter.
    wide:
        Handicap of wide filters: what the logarithm of the innovation's variance counts more.
    delay:
        How long before the latest sample instants are read [s].
    noise:
        Variance of the positions' noise, for their covariance; 0: it is estimated.

    """

    n: cython.Py_ssize_t
    m: cython.Py_ssize_t
    wide: cython.double
    delay: cython.double
    known_noise: cython.double
    delayed: cython.bint
    power: cython.double[::1]         # process density of each filter, but for the period
    four: cython.double[::1]          # 1 for filters of order 4
    noise: cython.double[:, ::1]      # coefficients of the process noise: order 3, order 4
    scale: cython.double[::1]
    position: Channel
    velocity: Channel
    trust: cython.double[:, ::1]      # (n, V_NUMBERS)
    p: cython.double[:, ::1]          # covariances, (10, M); `ahead`: before the latest sample
    ahead: cython.double[:, ::1]
    gain: cython.double[:, ::1]       # (4, M); `gain_before`: those of the sample before
    gain_before: cython.double[:, ::1]
    s: cython.double[::1]             # variance of the innovation
    ls: cython.double[::1]            # its logarithm, with the handicap
    lsum: cython.double[::1]          # forgetful mean of that
    now: cython.double[:, ::1]        # weighted state after the latest sample, (4, n), SI
    instead: cython.double[::1]       # velocities for those that are not measured
    moves: cython.double[:, ::1]      # what `travel` works on, (4, n)
    out: cython.double[:, ::1]        # what was read: 4 rows of state, 10 of covariance, SI
    smooth: cython.double[:, ::1]     # states of one joint's filters at the instant, (4, M)
    work: cython.double[:, ::1]       # (16, M)
    mixed: cython.double[::1]         # mean state, variances of one derivative and of the level
    # The run.
    steps: cython.longlong
    time: cython.double
    dt: cython.double
    rate: cython.double
    period: cython.double             # mean step
    usual: cython.double              # mean of steps near the usual one
    unusual: cython.int
    reference: cython.double          # step that gains are found for while steps are near it
    used: cython.double               # step that gains were found for
    steady: cython.longlong           # steps since the gains changed
    span: cython.double
    with_velocity: cython.bint
    missing: cython.int
    # The latest steps.
    size: cython.Py_ssize_t
    oldest: cython.longlong
    times: cython.double[:, ::1]
    ratios: cython.double[:, ::1]     # step to the next one, in TIME_UNIT
    covariances: cython.double[:, ::1]
    gains: cython.double[:, ::1]
    spreads: cython.double[:, ::1]    # variances of the innovations
    taps: cython.double[:, ::1]       # weights of innovations since an instant, (4 steps, M)
    smoothed: cython.double[:, ::1]   # covariance there with so many steps, (10 steps, M)
    tap_step: cython.double           # step that the taps are for, once gains are steady

    def __init__(self, n: int, bandwidths: Any, wide: float, delay: float,
                 noise: float = 0.0) -> None:
        self.n, self.m, self.wide = n, len(bandwidths), wide
        self.delay, self.delayed = delay, delay > 0.0
        self.known_noise = noise
        m: cython.Py_ssize_t = self.m
        self.power = row([(2 * 3.141592653589793 * f) ** (2 * order) for order, f in bandwidths])
        self.four = row([1.0 if order == 4 else 0.0 for order, _ in bandwidths])
        self.scale = row(SCALE)
        self.noise = table(2, 10)
        for order in (3, 4):
            for k, (i, j) in enumerate(PAIRS):
                if j < order:
                    self.noise[order - 3, k] = SCALE[i] * SCALE[j] / (
                        (2 * order - 1 - i - j) * FACTORIAL[order - 1 - i]
                        * FACTORIAL[order - 1 - j])
        self.position, self.velocity = Channel(n, m), Channel(n, m)
        self.trust = table(n, V_NUMBERS)
        self.p, self.ahead = table(10, m), table(10, m)
        self.gain, self.gain_before = table(4, m), table(4, m)
        self.s, self.ls, self.lsum = zeros(m), zeros(m), zeros(m)
        self.now, self.out, self.instead = table(4, n), table(14, n), zeros(n)
        self.smooth, self.work, self.mixed = table(4, m), table(16, m), zeros(6)
        self.moves = table(4, n)
        self.times = self.ratios = self.covariances = self.gains = self.spreads = table(1, 1)
        self.size = self.steps = 0
        self.oldest = 1
        self._make_room(32 if self.delayed else 1)

    def start(self, time: cython.double, position: cython.double[::1]) -> None:
        """Begin a run at a position."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        self.steps, self.oldest = 0, 1
        self.time, self.dt = time, 0.0
        self.period = self.usual = self.reference = self.used = self.span = self.tap_step = 0.0
        self.unusual, self.steady, self.missing, self.with_velocity = 0, 0, 0, False
        diagonal = (0, 4, 7, 9)
        for k in range(m):
            for i in range(10):
                self.p[i, k] = 0.0
            for i in range(4):
                self.p[diagonal[i], k] = (PRIOR[i] * SCALE[i]) ** 2
                self.gain[i, k] = 0.0
            self.p[9, k] *= self.four[k]
            self.lsum[k] = 0.0
            self.s[k] = 1.0
        self._start_channel(self.position, position)
        for j in range(self.n):
            for i in range(4):
                self.now[i, j] = 0.0
            self.now[0, j] = position[j]
            self.trust[j, V_COUNT] = 0.0

    def _start_channel(self, c: Channel, z: cython.double[::1]) -> None:
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for j in range(self.n):
            for k in range(j * self.m, (j + 1) * self.m):
                c.x[0, k] = z[j]
                for i in range(1, 4):
                    c.x[i, k] = 0.0
                c.mean[k] = c.before[k] = 0.0
                c.weight[k] = 1.0 / self.m
            c.joint[j, LAST] = z[j]
            c.joint[j, PENDING] = c.joint[j, WAITING] = c.joint[j, ENVELOPE] = 0.0

    # ---- a sample

    def measure(self, time: cython.double, position: cython.double[::1],
                velocity: cython.double[::1], measured: cython.bint,
                rate: cython.double) -> None:
        """
        Take a sample, later than the one before.

        Parameters
        ----------
        time:
            When it was taken [s].
        position, velocity, measured:
            The velocity is read if it was measured.
        rate:
            Seconds of the clock that velocities are of in a second of `time`.

        """
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        dt: cython.double = time - self.time
        self.time, self.dt, self.rate = time, dt, rate
        self.steps += 1
        step: cython.double = self._pace(dt)
        self._predict_covariances(step)
        change: cython.double = self._update_gains()
        self.steady = self.steady + 1 if step == self.used and change < 1e-7 else 0
        self.used = step
        share: cython.double = 1.0 - exp(-dt / WINDOW)
        first: cython.double = 1.0 / self.steps
        share = share if share > first else first
        self.span = (1.0 - share) * self.span + 1.0
        for k in range(m):
            self.lsum[k] += share * (self.ls[k] - self.lsum[k])
        slot: cython.Py_ssize_t = 0
        if self.delayed:
            if (self.steps > self.size and self.size < LARGEST_RING
                    and self.times[self.steps % self.size, 0] > time - 1.25 * self.delay - dt):
                self._make_room(2 * self.size)
            slot = self._remember(step)
        jump: cython.double = PLAUSIBLE * dt if dt > SLOW and not self.delayed else 0.0
        r: cython.double = dt / TIME_UNIT
        self._advance(self.position, position, position, r, share, 0.5 * dt * jump, slot)
        x: cython.double[:, ::1] = self.position.x
        w: cython.double[::1] = self.position.weight
        for j in range(self.n):
            for i in range(4):
                mean: cython.double = 0.0
                for k in range(j * m, j * m + m):
                    mean += w[k] * x[i, k]
                self.now[i, j] = mean / self.scale[i]
        if not measured and not self.with_velocity:
            return
        self.missing = 0 if measured else self.missing + 1
        whole: cython.bint = measured
        for j in range(self.n):
            whole = whole and isfinite(velocity[j])
        if not self.with_velocity:
            self.with_velocity = True
            for j in range(self.n):
                self.trust[j, V_COUNT] = 0.0
                self.instead[j] = velocity[j] if isfinite(velocity[j]) else self.now[1, j] / rate
            self._start_channel(self.velocity, self.instead)
        else:
            for j in range(self.n):
                self.instead[j] = velocity[j] if whole else self.now[1, j] / rate
            self._advance(self.velocity, velocity if measured else self.instead, self.instead, r,
                          share, jump, slot)
        for j in range(self.n):
            self._compare(j, position[j], velocity[j] * rate if measured else NAN)
        self.with_velocity = self.missing < 20

    @cython.cfunc
    @cython.exceptval(check=False)
    def _pace(self, dt: cython.double) -> cython.double:
        """Follow the steps; return the one that gains are found for: the usual one if near it."""
        k: cython.longlong = self.steps
        share: cython.double = 0.01 if k > 100 else 1.0 / k
        if k == 1:
            self.period = self.usual = dt
            return dt
        limited: cython.double = 3.0 * self.period
        self.period += share * ((dt if dt < limited else limited) - self.period)
        if fabs(dt - self.usual) < 0.3 * self.usual:
            self.usual += share * (dt - self.usual)
            self.unusual = 0
        else:
            self.unusual += 1
            if self.unusual > 8:
                self.usual = dt
                self.unusual = 0
        if k >= 16 and not 0.985 * self.usual < self.reference < 1.015 * self.usual:
            self.reference = self.usual
        near: cython.bint = 0.85 * self.reference < dt < 1.15 * self.reference
        return self.reference if near else dt

    @cython.cfunc
    @cython.exceptval(check=False)
    def _predict_covariances(self, dt: cython.double) -> cython.void:
        """Predict the covariances of all filters: P = F P F' + Q."""
        k: cython.Py_ssize_t
        r: cython.double = dt / TIME_UNIT
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        d1: cython.double = dt
        d2: cython.double = d1 * d1
        d3: cython.double = d2 * d1
        d4: cython.double = d2 * d2
        d5: cython.double = d4 * d1
        d6: cython.double = d3 * d3
        d7: cython.double = d6 * d1
        # Beyond these densities a filter is dead-beat.
        cap3: cython.double = 2e9 / d5
        cap4: cython.double = 2.5e10 / d7
        p: cython.double[:, ::1] = self.p
        c: cython.double[:, ::1] = self.noise
        for k in range(self.m):
            a00: cython.double = p[0, k] + r * p[1, k] + r2 * p[2, k] + r3 * p[3, k]
            a01: cython.double = p[1, k] + r * p[4, k] + r2 * p[5, k] + r3 * p[6, k]
            a02: cython.double = p[2, k] + r * p[5, k] + r2 * p[7, k] + r3 * p[8, k]
            a03: cython.double = p[3, k] + r * p[6, k] + r2 * p[8, k] + r3 * p[9, k]
            a11: cython.double = p[4, k] + 2.0 * r * p[5, k] + 3.0 * r2 * p[6, k]
            a12: cython.double = p[5, k] + 2.0 * r * p[7, k] + 3.0 * r2 * p[8, k]
            a13: cython.double = p[6, k] + 2.0 * r * p[8, k] + 3.0 * r2 * p[9, k]
            a22: cython.double = p[7, k] + 3.0 * r * p[8, k]
            a23: cython.double = p[8, k] + 3.0 * r * p[9, k]
            is4: cython.double = self.four[k]
            density: cython.double = self.power[k] * self.period
            cap: cython.double = cap4 if is4 > 0.5 else cap3
            density = density if density < cap else cap
            f: cython.double = density * is4
            t: cython.double = density - f
            p[0, k] = (a00 + r * a01 + r2 * a02 + r3 * a03
                       + f * c[1, 0] * d7 + t * c[0, 0] * d5)
            p[1, k] = a01 + 2.0 * r * a02 + 3.0 * r2 * a03 + f * c[1, 1] * d6 + t * c[0, 1] * d4
            p[2, k] = a02 + 3.0 * r * a03 + f * c[1, 2] * d5 + t * c[0, 2] * d3
            p[3, k] = a03 + f * c[1, 3] * d4
            p[4, k] = a11 + 2.0 * r * a12 + 3.0 * r2 * a13 + f * c[1, 4] * d5 + t * c[0, 4] * d3
            p[5, k] = a12 + 3.0 * r * a13 + f * c[1, 5] * d4 + t * c[0, 5] * d2
            p[6, k] = a13 + f * c[1, 6] * d3
            p[7, k] = a22 + 3.0 * r * a23 + f * c[1, 7] * d3 + t * c[0, 7] * d1
            p[8, k] = a23 + f * c[1, 8] * d2
            p[9, k] = p[9, k] + f * c[1, 9] * d1

    @cython.cfunc
    @cython.exceptval(check=False)
    def _update_gains(self) -> cython.double:
        """Update covariances and gains with one sample; return the gains' relative change."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        p: cython.double[:, ::1] = self.p
        g: cython.double[:, ::1] = self.gain
        change: cython.double = 0.0
        for i in range(10):
            for k in range(self.m):
                self.ahead[i, k] = p[i, k]
        for k in range(self.m):
            s: cython.double = p[0, k] + 1.0
            g0: cython.double = p[0, k] / s
            g1: cython.double = p[1, k] / s
            g2: cython.double = p[2, k] / s
            g3: cython.double = p[3, k] / s
            p[4, k] -= g1 * p[1, k]
            p[5, k] -= g1 * p[2, k]
            p[6, k] -= g1 * p[3, k]
            p[7, k] -= g2 * p[2, k]
            p[8, k] -= g2 * p[3, k]
            p[9, k] -= g3 * p[3, k]
            # Exact for a noise of variance 1, and better conditioned.
            p[0, k], p[1, k], p[2, k], p[3, k] = g0, g1, g2, g3
            off: cython.double = fabs(g[0, k] - g0) - change * g0
            if off > 0.0:
                change = fabs(g[0, k] - g0) / g0
            off = fabs(g[2, k] - g2) - change * fabs(g2)
            if off > 0.0:
                change = fabs(g[2, k] - g2) / (fabs(g2) + LEAST)
            for i in range(4):
                self.gain_before[i, k] = g[i, k]
            g[0, k], g[1, k], g[2, k], g[3, k] = g0, g1, g2, g3
            self.s[k] = s
        wide: cython.double = self.wide
        if self.delayed:
            # The more samples in a window, the more alike are the errors of neighbours.
            dense: cython.double = SPARSE / self.period
            dense = dense if dense < DENSEST else DENSEST
            wide *= sqrt(dense)
        for k in range(self.m):
            self.ls[k] = (1.0 + wide) * log(self.s[k])
        return change

    @cython.cfunc
    @cython.exceptval(check=False)
    def _advance(self, c: Channel, z: cython.double[::1], instead: cython.double[::1],
                 r: cython.double, share: cython.double, plausible: cython.double,
                 slot: cython.Py_ssize_t) -> cython.void:
        """Predict, decide what the sample is worth, update, weigh: all joints of a channel."""
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        i: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        first: cython.Py_ssize_t
        lanes: cython.Py_ssize_t = self.n * m
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        x: cython.double[:, ::1] = c.x
        w: cython.double[::1] = c.weight
        mean: cython.double[::1] = c.mean
        g: cython.double[:, ::1] = self.gain
        s: cython.double[::1] = self.s
        u: cython.double[:, ::1] = c.joint
        states: cython.double[:, ::1] = c.states
        errors: cython.double[:, ::1] = c.errors
        for k in range(lanes):
            x3: cython.double = x[3, k]
            x2: cython.double = x[2, k]
            x1: cython.double = x[1, k]
            x[0, k] = x[0, k] + r * x1 + r2 * x2 + r3 * x3
            x[1, k] = x1 + 2.0 * r * x2 + 3.0 * r2 * x3
            x[2, k] = x2 + 3.0 * r * x3
        for j in range(self.n):
            first = j * m
            at: cython.double = z[j]
            known: cython.bint = isfinite(at)
            same: cython.bint = at == u[j, LAST]
            if known:
                follow_quantum(u, j, at)
            # Noise is never below that of rounding: silence between two steps proves nothing.
            least: cython.double = 0.0
            if u[j, FIT] > 0.7:
                least = u[j, QUANTUM] * u[j, QUANTUM] / 12.0
            foreseen: cython.double = 0.0
            noise: cython.double = 0.0
            variance: cython.double = 0.0
            for k in range(m):
                foreseen += w[first + k] * x[0, first + k]
            for k in range(m):
                apart: cython.double = x[0, first + k] - foreseen
                own: cython.double = mean[first + k] if mean[first + k] > least else least
                noise += w[first + k] * own
                variance += w[first + k] * (s[k] * own + apart * apart)
            u[j, NOISE] = noise
            score: cython.bint = known
            if self.steps > FIRST_WAIT and known:
                deviation: cython.double = at - foreseen
                limit: cython.double = HOLD * (sqrt(variance) + u[j, ENVELOPE])
                if u[j, WAITING] > 0.0:
                    score = self._decide(c, j, at, r, slot)
                elif fabs(deviation) > limit:
                    taken: cython.bint = fabs(deviation) < plausible and not same
                    score = taken
                    u[j, WAITING] = 1.0
                    u[j, PENDING] = deviation
                    u[j, LIMIT], u[j, STEP] = limit, r
                    u[j, ODD] += 1.0
                    u[j, TAKEN] = 1.0 if taken else 0.0
                    u[j, WITHOUT] = foreseen
                    for i in range(1, 4):
                        without: cython.double = 0.0
                        for k in range(first, first + m):
                            without += w[k] * x[i, k]
                        u[j, WITHOUT + i] = without
                    for k in range(first, first + m):
                        c.before[k] = mean[k]
                else:
                    u[j, ENVELOPE] += 0.2 * (fabs(deviation) - u[j, ENVELOPE])
            if not score:
                at = foreseen if known else instead[j]
            for k in range(m):
                error: cython.double = at - x[0, first + k]
                if self.delayed:
                    states[slot, first + k] = x[0, first + k]
                    states[slot, lanes + first + k] = x[1, first + k]
                    states[slot, 2 * lanes + first + k] = x[2, first + k]
                    states[slot, 3 * lanes + first + k] = x[3, first + k]
                    errors[slot, first + k] = error
                x[0, first + k] += g[0, k] * error
                x[1, first + k] += g[1, k] * error
                x[2, first + k] += g[2, k] * error
                x[3, first + k] += g[3, k] * error
                if score:
                    mean[first + k] += share * (error * error / s[k] - mean[first + k])
            if score:
                self._weigh(c, first, least)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _weigh(self, c: Channel, first: cython.Py_ssize_t, least: cython.double) -> cython.void:
        """Turn the likelihoods of a joint's filters into weights."""
        k: cython.Py_ssize_t
        w: cython.double[::1] = c.weight
        mean: cython.double[::1] = c.mean
        best: cython.double = 1e300
        total: cython.double = 0.0
        span: cython.double = -0.5 * EVIDENCE * self.span
        for k in range(self.m):
            own: cython.double = mean[first + k] if mean[first + k] > least else least
            own = log(own + LEAST) + self.lsum[k]
            w[first + k] = own
            best = own if own < best else best
        for k in range(first, first + self.m):
            w[k] = exp(span * (w[k] - best))
            total += w[k]
        for k in range(first, first + self.m):
            w[k] /= total

    @cython.cfunc
    @cython.exceptval(check=False)
    def _decide(self, c: Channel, j: cython.Py_ssize_t, at: cython.double, r: cython.double,
                slot: cython.Py_ssize_t) -> cython.bint:
        """
        Decide, by the sample after it, about the sample that waits.

        Its own deviation p, the next one's d0 from where the joint would be without it: back
        within the limit, it was odd and is forgotten; as many times p as if velocity or
        acceleration had jumped, it was real, and what it says is added now. Else the next one
        waits too.
        """
        k: cython.Py_ssize_t
        i: cython.Py_ssize_t
        first: cython.Py_ssize_t = j * self.m
        u: cython.double[:, ::1] = c.joint
        x: cython.double[:, ::1] = c.x
        h: cython.double[:, ::1] = self.gain_before
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        limit: cython.double = u[j, LIMIT]
        pending: cython.double = u[j, PENDING]
        waiting: cython.Py_ssize_t = int(u[j, WAITING])
        taken: cython.bint = u[j, TAKEN] > 0.0
        s3: cython.double = u[j, WITHOUT + 3]
        s2: cython.double = u[j, WITHOUT + 2] + 3.0 * r * s3
        s1: cython.double = u[j, WITHOUT + 1] + 2.0 * r * u[j, WITHOUT + 2] + 3.0 * r2 * s3
        s0: cython.double = (u[j, WITHOUT] + r * u[j, WITHOUT + 1] + r2 * u[j, WITHOUT + 2]
                             + r3 * s3)
        deviation: cython.double = at - s0
        ratio: cython.double = deviation / pending
        change: cython.double = 0.0
        # Of equal steps 2, 4, 8 for a jump of velocity, acceleration, jerk; less after a pause.
        onward: cython.double = r / u[j, STEP] if r < u[j, STEP] else 1.0
        least: cython.double = exp(0.58 * log(1.0 + onward))
        most: cython.double = exp(3.17 * log(1.0 + onward))
        if fabs(deviation) <= limit and ratio < 0.5:        # it was odd
            if taken:
                change = -pending
                for k in range(first, first + self.m):
                    c.mean[k] = c.before[k]
        elif not taken and (ratio < least or ratio > most) and waiting < LONGEST_WAIT:
            u[j, WAITING] += 1.0
            u[j, WITHOUT], u[j, WITHOUT + 1], u[j, WITHOUT + 2] = s0, s1, s2
            if ratio <= 0.5 or ratio > most:
                u[j, PENDING] = deviation
            return False
        elif not taken:                                     # it was real
            change = pending
        u[j, WAITING] = 0.0
        if change != 0.0:
            for k in range(self.m):
                i = first + k
                x[0, i] += change * (h[0, k] + r * h[1, k] + r2 * h[2, k] + r3 * h[3, k])
                x[1, i] += change * (h[1, k] + 2.0 * r * h[2, k] + 3.0 * r2 * h[3, k])
                x[2, i] += change * (h[2, k] + 3.0 * r * h[3, k])
                x[3, i] += change * h[3, k]
                if self.delayed:
                    c.errors[(slot - waiting + self.size) % self.size, i] += change
        size: cython.double = fabs(deviation)
        size = size if size < 3.0 * limit else 3.0 * limit
        u[j, ENVELOPE] += 0.2 * (size - u[j, ENVELOPE])
        return True

    # ---- velocities

    @cython.cfunc
    @cython.exceptval(check=False)
    def _compare(self, j: cython.Py_ssize_t, z: cython.double, v: cython.double) -> cython.void:
        """
        Compare a joint's velocity with its position.

        Lag and scale by regression of the leaky integral of (velocity less position step) on
        those of the velocity's change and of the velocity.
        """
        y: cython.double[:, ::1] = self.trust
        dt: cython.double = self.dt
        if not isfinite(v):
            y[j, V_COUNT] = 0.0
            y[j, V_MISSING] += 1.0
            return
        y[j, V_MISSING] = 0.0
        if v != 0.0:
            y[j, V_ALIVE] += 1.0
        if y[j, V_COUNT] > 0.0:
            step: cython.double = z - y[j, V_POSITION]
            way: cython.double = 0.5 * (v + y[j, V_LATEST]) * dt
            wrong: cython.double = way - step
            change: cython.double = v - y[j, V_LATEST]
            k: cython.double = exp(-dt / MEMORY)
            y[j, V_WRONG] = k * y[j, V_WRONG] + wrong
            y[j, V_CHANGE] = k * y[j, V_CHANGE] + change
            y[j, V_WAY] = k * y[j, V_WAY] + way
            left: cython.double = (y[j, V_WRONG] + y[j, V_LAG] * y[j, V_CHANGE]
                                   - y[j, V_SCALE] * y[j, V_WAY])
            back: cython.double = v * dt - step
            k = 1.0 - exp(-dt)
            if self.steps > FIRST_WAIT:
                y[j, V_SEEN] += 1.0
                first: cython.double = 1.0 / y[j, V_SEEN]
                k = k if k > first else first
            y[j, V_DIFFERENCED] += k * (back * back - y[j, V_DIFFERENCED])
            # A velocity of the step's end leaves half of what the acceleration adds to it.
            back -= 0.5 * self.now[2, j] * dt * dt
            y[j, V_TRUE] += k * (back * back - y[j, V_TRUE])
            y[j, V_LEFT] += k * (left * left - y[j, V_LEFT])
            y[j, V_NOISE] += k * (self.position.joint[j, NOISE] - y[j, V_NOISE])
            k = exp(-dt / 0.1)
            b: cython.double = k * y[j, V_WRONG_LONG] + wrong
            c: cython.double = k * y[j, V_CHANGE_LONG] + change
            x: cython.double = k * y[j, V_WAY_LONG] + way
            y[j, V_WRONG_LONG], y[j, V_CHANGE_LONG], y[j, V_WAY_LONG] = b, c, x
            if y[j, V_COUNT] > 10.0:
                k = exp(-dt / 2.0)
                y[j, V_WC] = k * y[j, V_WC] - b * c * dt
                y[j, V_CC] = k * y[j, V_CC] + c * c * dt
                y[j, V_WX] = k * y[j, V_WX] + b * x * dt
                y[j, V_XX] = k * y[j, V_XX] + x * x * dt
                y[j, V_XC] = k * y[j, V_XC] - x * c * dt
                cc: cython.double = y[j, V_CC] + 1e-9
                xx: cython.double = y[j, V_XX] + 1e-7
                det: cython.double = cc * xx - y[j, V_XC] * y[j, V_XC]
                lag: cython.double = (y[j, V_WC] * xx - y[j, V_WX] * y[j, V_XC]) / det
                lag = lag if lag > 0.0 else 0.0
                y[j, V_LAG] = lag if lag < 0.05 else 0.05
                scale: cython.double = (y[j, V_WX] - y[j, V_LAG] * y[j, V_XC]) / xx
                scale = scale if scale > -0.1 else -0.1
                y[j, V_SCALE] = scale if scale < 0.1 else 0.1
        y[j, V_POSITION], y[j, V_LATEST] = z, v
        y[j, V_COUNT] += 1.0

    # ---- reading

    def read(self, at: cython.double, fresh: cython.bint, rate: cython.double,
             spread: cython.bint) -> int:
        """
        Find the motion at an instant.

        Parameters
        ----------
        at:
            The instant [s].
        fresh:
            Whether a sample was taken since the last time.
        rate:
            As for `measure`; derivatives are by that clock.
        spread:
            Whether the covariance is wanted.

        Returns
        -------
        READ, and `values` and `variances` are those; TOO_EARLY: before the run began;
        TOO_LONG_AGO: more steps ago than are remembered.

        """
        j: cython.Py_ssize_t
        i: cython.longlong = self.steps
        k: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.n
        r: cython.double
        if self.delayed:
            i = self._step_before(at)
            if i <= 0:
                return TOO_EARLY if i == 0 else TOO_LONG_AGO
            self._make_taps(i)
        for j in range(n):
            r = self._states_at(self.position, j, i, at)
            self._mix(self.position, j, i, r, 2)
            for k in range(4):
                self.out[k, j] = self.mixed[k] / self.scale[k]
            if spread:
                self._spread(j, i, r)
            if self.with_velocity:
                self._fuse(j, at, fresh)
            self.out[1, j] /= rate
            self.out[2, j] /= rate * rate
            self.out[3, j] /= rate * rate * rate
        return READ

    @cython.cfunc
    @cython.exceptval(check=False)
    def _step_before(self, at: cython.double) -> cython.longlong:
        """Return the latest step not after an instant; 0: there is none, -1: forgotten."""
        k: cython.longlong = self.steps
        while k >= self.oldest and self.times[k % self.size, 0] > at + 1e-9:
            k -= 1
        if k >= self.oldest:
            return k
        return 0 if self.oldest == 1 else -1

    @cython.cfunc
    @cython.exceptval(check=False)
    def _states_at(self, c: Channel, j: cython.Py_ssize_t, i: cython.longlong,
                   at: cython.double) -> cython.double:
        """
        Write the states of a joint's filters at step i; return how far the instant is beyond.

        With a delay these are smoothed: the predicted state, and the innovations since then by
        their taps.
        """
        k: cython.Py_ssize_t
        a: cython.Py_ssize_t
        step: cython.longlong
        m: cython.Py_ssize_t = self.m
        first: cython.Py_ssize_t = j * m
        lanes: cython.Py_ssize_t = self.n * m
        b: cython.double[:, ::1] = self.smooth
        if not self.delayed:
            for a in range(4):
                for k in range(m):
                    b[a, k] = c.x[a, first + k]
            return (at - self.time) / TIME_UNIT
        slot: cython.Py_ssize_t = i % self.size
        for a in range(4):
            for k in range(m):
                b[a, k] = c.states[slot, a * lanes + first + k]
        taps: cython.double[:, ::1] = self.taps
        errors: cython.double[:, ::1] = c.errors
        since: cython.Py_ssize_t = 0
        for step in range(i, self.steps + 1):
            row: cython.Py_ssize_t = step % self.size
            for k in range(m):
                e: cython.double = errors[row, first + k]
                b[0, k] += taps[since, k] * e
                b[1, k] += taps[since + 1, k] * e
                b[2, k] += taps[since + 2, k] * e
                b[3, k] += taps[since + 3, k] * e
            since += 4
        return (at - self.times[slot, 0]) / TIME_UNIT

    @cython.cfunc
    @cython.exceptval(check=False)
    def _covariance_of(self, i: cython.longlong) -> cython.Py_ssize_t:
        """Return the first of the ten rows of `smoothed` for step i."""
        return 10 * (self.steps - i)

    @cython.cfunc
    @cython.exceptval(check=False)
    def _mix(self, c: Channel, j: cython.Py_ssize_t, i: cython.longlong, r: cython.double,
             what: cython.int) -> cython.void:
        """
        Mix a joint's filters, r onward.

        Writes the mean state, the variance of component `what`, and that of component 0 if it is
        a velocity's.
        """
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        first: cython.Py_ssize_t = j * m
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        h: cython.double = r * TIME_UNIT
        h3: cython.double = h * h * h
        x: cython.double[:, ::1] = self.smooth
        p: cython.double[:, ::1] = self.smoothed if self.delayed else self.p
        top: cython.Py_ssize_t = self._covariance_of(i) if self.delayed else 0
        m0: cython.double = 0.0
        m1: cython.double = 0.0
        m2: cython.double = 0.0
        m3: cython.double = 0.0
        total: cython.double = 0.0
        square: cython.double = 0.0
        inner: cython.double = 0.0
        level: cython.double = 0.0
        v: cython.double
        for k in range(m):
            w: cython.double = c.weight[first + k]
            if w < NEGLIGIBLE:
                continue
            total += w
            b3: cython.double = x[3, k]
            b2: cython.double = x[2, k] + 3.0 * r * b3
            b1: cython.double = x[1, k] + 2.0 * r * x[2, k] + 3.0 * r2 * b3
            b0: cython.double = x[0, k] + r * x[1, k] + r2 * x[2, k] + r3 * b3
            m0 += w * b0
            m1 += w * b1
            m2 += w * b2
            m3 += w * b3
            if what == 2:
                square += w * b2 * b2
                v = p[top + 7, k] + 6.0 * r * p[top + 8, k] + 9.0 * r2 * p[top + 9, k]
            else:
                square += w * b1 * b1
                v = (p[top + 4, k] + 4.0 * r2 * p[top + 7, k] + 9.0 * r2 * r2 * p[top + 9, k]
                     + 4.0 * r * p[top + 5, k] + 6.0 * r2 * p[top + 6, k]
                     + 12.0 * r3 * p[top + 8, k])
                ahead: cython.double = b0 * b0 + c.mean[first + k] * (
                    p[top, k] + 2.0 * r * p[top + 1, k] + r2 * p[top + 4, k])
                level += w * ahead
                if h > 1e-3:        # what the process adds on the way
                    density: cython.double = self.power[k] * self.period
                    if self.four[k] > 0.5:
                        v += density * self.noise[1, 4] * h3 * h * h
                    else:
                        v += density * self.noise[0, 4] * h3
            inner += w * c.mean[first + k] * v
        o: cython.double[::1] = self.mixed
        o[0], o[1], o[2], o[3] = m0 / total, m1 / total, m2 / total, m3 / total
        square = square / total - (o[2] * o[2] if what == 2 else o[1] * o[1])
        o[4] = (square if square > 0.0 else 0.0) + inner / total
        level = level / total - o[0] * o[0]
        o[5] = level if level > 0.0 else 0.0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _spread(self, j: cython.Py_ssize_t, i: cython.longlong, r: cython.double) -> cython.void:
        """Write the covariance of a joint's mixed state: within and between the filters."""
        k: cython.Py_ssize_t
        a: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        first: cython.Py_ssize_t = j * m
        r2: cython.double = r * r
        r3: cython.double = r2 * r
        x: cython.double[:, ::1] = self.smooth
        p: cython.double[:, ::1] = self.smoothed if self.delayed else self.p
        top: cython.Py_ssize_t = self._covariance_of(i) if self.delayed else 0
        w: cython.double[::1] = self.position.weight
        mean: cython.double[::1] = self.position.mean
        c: cython.double[:, ::1] = self.work
        for a in range(10):
            c[a, 0] = 0.0
        m0: cython.double = 0.0
        m1: cython.double = 0.0
        m2: cython.double = 0.0
        m3: cython.double = 0.0
        for k in range(m):
            m0 += w[first + k] * x[0, k]
            m1 += w[first + k] * x[1, k]
            m2 += w[first + k] * x[2, k]
            m3 += w[first + k] * x[3, k]
        for k in range(m):
            v: cython.double = w[first + k]
            if v < NEGLIGIBLE:
                continue
            s: cython.double = v * (self.known_noise if self.known_noise > 0.0
                                    else mean[first + k])
            b0: cython.double = x[0, k] - m0
            b1: cython.double = x[1, k] - m1
            b2: cython.double = x[2, k] - m2
            b3: cython.double = x[3, k] - m3
            c[0, 0] += s * p[top, k] + v * b0 * b0
            c[1, 0] += s * p[top + 1, k] + v * b0 * b1
            c[2, 0] += s * p[top + 2, k] + v * b0 * b2
            c[3, 0] += s * p[top + 3, k] + v * b0 * b3
            c[4, 0] += s * p[top + 4, k] + v * b1 * b1
            c[5, 0] += s * p[top + 5, k] + v * b1 * b2
            c[6, 0] += s * p[top + 6, k] + v * b1 * b3
            c[7, 0] += s * p[top + 7, k] + v * b2 * b2
            c[8, 0] += s * p[top + 8, k] + v * b2 * b3
            c[9, 0] += s * p[top + 9, k] + v * b3 * b3
        # r onward
        a00: cython.double = c[0, 0] + r * c[1, 0] + r2 * c[2, 0] + r3 * c[3, 0]
        a01: cython.double = c[1, 0] + r * c[4, 0] + r2 * c[5, 0] + r3 * c[6, 0]
        a02: cython.double = c[2, 0] + r * c[5, 0] + r2 * c[7, 0] + r3 * c[8, 0]
        a03: cython.double = c[3, 0] + r * c[6, 0] + r2 * c[8, 0] + r3 * c[9, 0]
        a11: cython.double = c[4, 0] + 2.0 * r * c[5, 0] + 3.0 * r2 * c[6, 0]
        a12: cython.double = c[5, 0] + 2.0 * r * c[7, 0] + 3.0 * r2 * c[8, 0]
        a13: cython.double = c[6, 0] + 2.0 * r * c[8, 0] + 3.0 * r2 * c[9, 0]
        a22: cython.double = c[7, 0] + 3.0 * r * c[8, 0]
        a23: cython.double = c[8, 0] + 3.0 * r * c[9, 0]
        o: cython.double[:, ::1] = self.out
        t: cython.double[::1] = self.scale
        o[4, j] = a00 + r * a01 + r2 * a02 + r3 * a03
        o[5, j] = (a01 + 2.0 * r * a02 + 3.0 * r2 * a03) / t[1]
        o[6, j] = (a02 + 3.0 * r * a03) / t[2]
        o[7, j] = a03 / t[3]
        o[8, j] = (a11 + 2.0 * r * a12 + 3.0 * r2 * a13) / (t[1] * t[1])
        o[9, j] = (a12 + 3.0 * r * a13) / (t[1] * t[2])
        o[10, j] = a13 / (t[1] * t[3])
        o[11, j] = (a22 + 3.0 * r * a23) / (t[2] * t[2])
        o[12, j] = a23 / (t[2] * t[3])
        o[13, j] = c[9, 0] / (t[3] * t[3])

    @cython.cfunc
    @cython.exceptval(check=False)
    def _fuse(self, j: cython.Py_ssize_t, at: cython.double, fresh: cython.bint) -> cython.void:
        """
        Let the velocity's acceleration into what was read of a joint, as far as it proves right.

        Its variance is raised by what shows that it is not what it claims: misfit of both
        accelerations, by at most what the integral could hide; a lag beyond a millisecond.
        """
        y: cython.double[:, ::1] = self.trust
        y[j, V_SHARE] = 0.0
        if (self.steps < 30 or y[j, V_ALIVE] < 10.0 or y[j, V_MISSING] > 2.0
                or self._differenced(j)):
            return
        o: cython.double[:, ::1] = self.out
        unit: cython.double = TIME_UNIT
        ap: cython.double = o[2, j]
        sp: cython.double = self.mixed[4] * 4.0 / (unit * unit * unit * unit) + 1e-12
        wanted: cython.double = at + y[j, V_LAG]
        i: cython.longlong = self.steps
        if self.delayed:
            i = self._step_before(wanted)
        r: cython.double = self._states_at(self.velocity, j, i, wanted)
        self._mix(self.velocity, j, i, r, 1)
        scale: cython.double = (1.0 + y[j, V_SCALE]) / self.rate
        av: cython.double = self.mixed[1] / unit / scale
        sv: cython.double = self.mixed[4] / (unit * unit) + 1e-12
        apart: cython.double = (av - ap) * (av - ap)
        d: cython.double = apart / (sp + sv)
        d = d if d < 50.0 else 50.0
        dt: cython.double = self.dt if fresh else 0.0
        misfit: cython.double = y[j, V_MISFIT]
        near: cython.double = misfit + (1.0 - exp(-dt / 0.2)) * (d - misfit)
        slow: cython.double = misfit * exp(-dt / 5.0)
        misfit = near if d >= misfit or near > slow else slow
        y[j, V_MISFIT] = misfit
        excess: cython.double = misfit - TOLERATED
        excess = excess * excess * (sp + sv) if excess > 0.0 else 0.0
        hidden: cython.double = y[j, V_LEFT] - MARGIN * y[j, V_NOISE]
        hidden = WORST * hidden / (MEMORY * MEMORY * MEMORY * MEMORY) if hidden > 0.0 else 0.0
        late: cython.double = (y[j, V_LAG] - EARLY_LAG) / LATE_LAG
        late = 0.0 if late < 0.0 else late if late < 1.0 else 1.0
        sv += (excess if excess < hidden else hidden) + late * apart
        w: cython.double = sp / (sp + sv)
        y[j, V_SHARE] = w
        o[2, j] = ap + w * (av - ap)
        o[1, j] += w * (self.mixed[0] / scale - o[1, j])
        o[3, j] += w * (self.mixed[2] / self.scale[2] / scale - o[3, j])
        # Rows and columns of the covariance shrink as the deviations do.
        k: cython.double = sqrt(1.0 - w)
        own: cython.double = o[8, j]
        level: cython.double = self.mixed[5] / (scale * scale)
        rest: cython.double = (1.0 - w) * (1.0 - w) * own + w * w * level
        f: cython.double = sqrt(rest / own) if rest < own else 1.0
        o[6, j] *= k
        o[9, j] *= k * f
        o[12, j] *= k
        o[11, j] *= k * k
        o[5, j] *= f
        o[8, j] *= f * f
        o[10, j] *= f

    @cython.cfunc
    @cython.exceptval(check=False)
    def _differenced(self, j: cython.Py_ssize_t) -> cython.bint:
        """Whether a velocity is merely the last step over its time, as far as noise can tell."""
        back: cython.double = self.trust[j, V_DIFFERENCED]
        return back < 0.01 * self.trust[j, V_NOISE] and back < self.trust[j, V_TRUE]

    def values(self) -> list[float]:
        """Return position, velocity, acceleration and jerk that were read, in a row."""
        j: cython.Py_ssize_t
        i: cython.Py_ssize_t
        row = []
        for i in range(4):
            for j in range(self.n):
                row.append(self.out[i, j])
        return row

    def variances(self) -> list[float]:
        """Return the upper triangle of the covariance of each joint: 10 n numbers, by rows."""
        j: cython.Py_ssize_t
        i: cython.Py_ssize_t
        row = []
        for i in range(4, 14):
            for j in range(self.n):
                row.append(self.out[i, j])
        return row

    # ---- the latest steps

    def _make_room(self, size: int) -> None:
        """Make room for so many steps; those that are remembered stay."""
        m: cython.Py_ssize_t = self.m
        lanes: cython.Py_ssize_t = self.n * m
        old: cython.Py_ssize_t = self.size
        new: cython.Py_ssize_t = size
        first: cython.longlong = self.oldest
        self.times = moved(self.times, old, new, 1, first, self.steps - 1)
        self.ratios = moved(self.ratios, old, new, 1, first, self.steps - 1)
        self.covariances = moved(self.covariances, old, new, 10 * m, first, self.steps - 1)
        self.gains = moved(self.gains, old, new, 4 * m, first, self.steps - 1)
        self.spreads = moved(self.spreads, old, new, m, first, self.steps - 1)
        for c in (self.position, self.velocity):
            c.states = moved(c.states, old, new, 4 * lanes, first, self.steps - 1)
            c.errors = moved(c.errors, old, new, lanes, first, self.steps - 1)
        self.taps, self.smoothed = table(4 * new, m), table(10 * new, m)
        self.size, self.tap_step = new, 0.0

    @cython.cfunc
    @cython.exceptval(check=False)
    def _remember(self, step: cython.double) -> cython.Py_ssize_t:
        """Remember a step for the smoother; return where."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        slot: cython.Py_ssize_t = self.steps % self.size
        if self.steps - self.oldest >= self.size:
            self.oldest += 1
        if self.steps > 1:
            self.ratios[(self.steps - 1) % self.size, 0] = step / TIME_UNIT
        self.times[slot, 0] = self.time
        for i in range(10):
            for k in range(m):
                self.covariances[slot, i * m + k] = self.ahead[i, k]
        for i in range(4):
            for k in range(m):
                self.gains[slot, i * m + k] = self.gain[i, k]
        for k in range(m):
            self.spreads[slot, k] = self.s[k]
        return slot

    @cython.cfunc
    @cython.exceptval(check=False)
    def _make_taps(self, i: cython.longlong) -> cython.void:
        """
        Find what the innovations since step i say of the predicted state there.

        For as many steps as are remembered, and once only, while the gains stay as they are.
        """
        if self.tap_step == self.used and self.steady > self.size:
            return
        self.tap_step = 0.0
        if self.steady > self.size:
            i = self.steps - self.size + 1
            self.tap_step = self.used
        k: cython.Py_ssize_t
        a: cython.Py_ssize_t
        b: cython.Py_ssize_t
        m: cython.Py_ssize_t = self.m
        slot: cython.Py_ssize_t = i % self.size
        since: cython.Py_ssize_t
        top: cython.Py_ssize_t = 0
        to: cython.Py_ssize_t
        c: cython.double[:, ::1] = self.work
        t: cython.double[:, ::1] = self.taps
        out: cython.double[:, ::1] = self.smoothed
        s: cython.double[:, ::1] = self.spreads
        g: cython.double[:, ::1] = self.gains
        for a in range(4):
            for b in range(4):
                to = 3 * a - a * (a - 1) // 2 + b if a <= b else 3 * b - b * (b - 1) // 2 + a
                for k in range(m):
                    c[4 * a + b, k] = self.covariances[slot, to * m + k]
                    out[to, k] = c[4 * a + b, k]
        for since in range(self.steps - i + 1):
            slot = (i + since) % self.size
            r: cython.double = self.ratios[slot, 0]
            r2: cython.double = r * r
            r3: cython.double = r2 * r
            for a in range(4):
                for k in range(m):
                    t[4 * since + a, k] = c[4 * a, k] / s[slot, k]
            to = 10 * since
            for a in range(4):
                for b in range(a, 4):
                    for k in range(m):
                        out[to, k] = out[top, k] - t[4 * since + a, k] * c[4 * b, k]
                    to += 1
                    top += 1
            top = 10 * since
            for a in range(4):
                b = 4 * a
                for k in range(m):
                    c0: cython.double = c[b, k]
                    x0: cython.double = c0 - c0 * g[slot, k]
                    x1: cython.double = c[b + 1, k] - c0 * g[slot, m + k]
                    x2: cython.double = c[b + 2, k] - c0 * g[slot, 2 * m + k]
                    x3: cython.double = c[b + 3, k] - c0 * g[slot, 3 * m + k]
                    c[b, k] = x0 + r * x1 + r2 * x2 + r3 * x3
                    c[b + 1, k] = x1 + 2.0 * r * x2 + 3.0 * r2 * x3
                    c[b + 2, k] = x2 + 3.0 * r * x3
                    c[b + 3, k] = x3

    # ---- what the clock asks

    def travel(self, position: cython.double[::1], unit: cython.double, span: cython.double,
               unforeseen: cython.double, agreed: cython.double[::1]) -> tuple[float, float]:
        """
        Find how far the joints have travelled along the move that is foreseen for one tick.

        No joint alone counts ticks: where one is at odds with the weighted median of what all
        have travelled, it gets the median's position in `agreed`.

        Parameters
        ----------
        position:
            The new reading.
        unit, span:
            Length of a tick, and time that has passed as far as is known [s].
        unforeseen:
            Acceleration of all joints together that nobody foresaw [rad/s2].
        agreed:
            Gets the positions.

        Returns
        -------
        The ticks travelled, and the length of the move in one tick [rad].

        """
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        k: cython.Py_ssize_t
        n: cython.Py_ssize_t = self.n
        now: cython.double[:, ::1] = self.now
        move: cython.double[:, ::1] = self.moves
        half: cython.double = 0.5 * span
        third: cython.double = span * span / 6.0
        square: cython.double = 1e-300
        along: cython.double = 0.0
        for j in range(n):
            agreed[j] = position[j]
            move[0, j] = unit * (now[1, j] + half * now[2, j] + third * now[3, j])
            move[1, j] = position[j] - now[0, j]
            square += move[0, j] * move[0, j]
            along += move[0, j] * move[1, j]
        tick: cython.double = sqrt(square)
        ticks: cython.double = along / square
        most: cython.double = 0.25 * unforeseen * span * span * tick
        most = most if most > 0.3 * square else 0.3 * square
        odd: cython.bint = False
        for j in range(n):
            odd = odd or fabs(move[0, j] * (move[1, j] - ticks * move[0, j])) >= most
        if not odd:
            return ticks, tick
        # The weighted median, by insertion.
        total: cython.double = 0.0
        for j in range(n):
            size: cython.double = fabs(move[0, j]) + 1e-15
            each: cython.double = move[1, j] / size
            each = each if move[0, j] > 0.0 else -each if move[0, j] < 0.0 else 0.0
            total += size
            k = j
            while k > 0 and move[2, k - 1] > each:
                move[2, k], move[3, k] = move[2, k - 1], move[3, k - 1]
                k -= 1
            move[2, k], move[3, k] = each, size
        passed: cython.double = 0.0
        i = 0
        while i < n - 1 and passed + move[3, i] < 0.5 * total:
            passed += move[3, i]
            i += 1
        median: cython.double = move[2, i]
        median = median if median > 0.0 else 0.0
        median = median if median < 40.0 else 40.0
        passed = 0.0
        for j in range(n):
            if fabs(move[0, j]) * fabs(move[1, j] - median * move[0, j]) > most:
                passed += fabs(move[0, j])
        if passed >= 0.5 * total:
            return ticks, tick
        along = 0.0
        for j in range(n):
            if fabs(move[0, j]) * fabs(move[1, j] - median * move[0, j]) > most:
                agreed[j] = now[0, j] + median * move[0, j]
            along += move[0, j] * (agreed[j] - now[0, j])
        return along / square, tick

    def encoder_steps(self, unit: cython.double) -> float:
        """Return by how many steps of its encoder the fastest joint will move in a time [s]."""
        j: cython.Py_ssize_t
        most: cython.double = 0.0
        u: cython.double[:, ::1] = self.position.joint
        for j in range(self.n):
            step: cython.double = u[j, QUANTUM] if u[j, FIT] > 0.7 else 0.0
            steps: cython.double = fabs(self.now[1, j]) * unit / (step if step > 1e-6 else 1e-6)
            most = steps if steps > most else most
        return most

    # ---- what others ask

    def state(self) -> list[float]:
        """Return the weighted state after the latest sample, in a row."""
        j: cython.Py_ssize_t
        i: cython.Py_ssize_t
        row = []
        for i in range(4):
            for j in range(self.n):
                row.append(self.now[i, j])
        return row

    def count(self) -> int:
        """Return the number of samples after the first."""
        return self.steps

    def odd_samples(self) -> list[int]:
        """Return how many samples of each joint waited for the next one, as improbable."""
        return [int(self.position.joint[j, ODD]) for j in range(self.n)]

    def has_velocity(self) -> bool:
        """Whether velocities come with the positions."""
        return self.with_velocity

    def velocity_facts(self) -> list[tuple[float, bool, float, float, float]]:
        """
        Return what is known of each joint's velocity.

        Samples that were not zero; whether it is merely differenced; lag [s]; share by which it
        is too large; its weight in the latest output.
        """
        y = self.trust
        return [(y[j, V_ALIVE], self._differenced(j), y[j, V_LAG], y[j, V_SCALE], y[j, V_SHARE])
                for j in range(self.n)]


@cython.cfunc
@cython.exceptval(check=False)
def follow_quantum(u: cython.double[:, ::1], j: cython.Py_ssize_t,
                   z: cython.double) -> cython.void:
    """Follow the step of which all changes are multiples, by Euclid's algorithm."""
    d: cython.double = fabs(z - u[j, LAST])
    u[j, LAST] = z
    if d < 1e-12:
        return
    q: cython.double = u[j, QUANTUM]
    u[j, CHANGES] += 1.0
    if q == 0.0:
        u[j, QUANTUM] = d
        u[j, CHANGES] = 1.0
        if u[j, FIT] == 0.0:
            u[j, FIT] = 1.0
        return
    rest: cython.double = fabs(d - q * floor(d / q + 0.5))
    u[j, FIT] += 0.05 * ((1.0 if rest < 0.1 * q else 0.0) - u[j, FIT])
    # Positions that went through single precision are no exact multiples.
    single: cython.double = 1.2e-7 * fabs(z)
    if rest > (1e-3 * q if 1e-3 * q > single else single):
        u[j, QUANTUM] = rest
    elif u[j, FIT] < 0.3 and u[j, CHANGES] > 60.0:
        u[j, QUANTUM] = 0.0

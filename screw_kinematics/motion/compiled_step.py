# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A sample of a steady run in machine code; imported only where Numba is installed."""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,misc"

from __future__ import annotations

import math

from numba import njit

from . import run_memory as at
from .compiled_admission import block, exact, in_order
from .steady_steps import FLOOR
from .wiener_process import TIME_UNIT

_swift = njit(error_model='numpy', fastmath={'contract'})
_summing = njit(error_model='numpy', fastmath={'reassoc', 'contract'})


@exact
def _renew_weights(filters, gains, span, rated):
    """Write the weights of a joint's filters: the likelihoods, over their sum."""
    best, total = math.inf, 0.0
    for m in range(len(filters)):
        score = math.log(filters[m, 4] + FLOOR) + gains[m, 9]
        if rated and gains[m, 11]:
            score += math.log(filters[m, 5] + FLOOR)
        filters[m, 7] = score
        best = min(best, score)
    for m in range(len(filters)):
        weight = math.exp(-0.5 * span * (filters[m, 7] - best))
        filters[m, 6] = weight
        total += weight
    for m in range(len(filters)):
        filters[m, 6] /= total


@_summing
def _correction(errors, taps, weights, products):
    """Return what the innovations since the instant say of its state; taps (4, M * length)."""
    filters, length = products.shape
    count = errors.shape[1]
    for m in range(filters):
        for t in range(count):
            products[m, t] = weights[m] * errors[m, t]
        for t in range(count, length):
            products[m, t] = 0.0
    flat = products.reshape(filters * length)
    a0, a1, a2, a3 = 0.0, 0.0, 0.0, 0.0
    for i in range(filters * length):
        a0 += taps[0, i] * flat[i]
        a1 += taps[1, i] * flat[i]
        a2 += taps[2, i] * flat[i]
        a3 += taps[3, i] * flat[i]
    return a0, a1, a2, a3


@_swift
def _weighted_mean(states, filters):
    """Return the mean of states with the filters' weights."""
    a0, a1, a2, a3 = 0.0, 0.0, 0.0, 0.0
    for m in range(len(filters)):
        weight = filters[m, 6]
        a0 += weight * states[m, 0]
        a1 += weight * states[m, 1]
        a2 += weight * states[m, 2]
        a3 += weight * states[m, 3]
    return a0, a1, a2, a3


@_swift
def _step_filters(x, gains, position, rate, rated, r, forget, predicted, errors, place):
    """
    Predict, and update with a sample, the filters of one joint.

    `predicted`, `errors` are for smoothing, and empty without.
    """
    keep = 1.0 - forget
    r2, r3 = r * r, r * r * r
    for m in range(len(x)):
        x3 = x[m, 3]
        x2 = x[m, 2] + 3.0 * r * x3
        x1 = x[m, 1] + 2.0 * r * x[m, 2] + 3.0 * r2 * x3
        x0 = x[m, 0] + r * x[m, 1] + r2 * x[m, 2] + r3 * x3
        e = position - x0
        if len(predicted):
            predicted[m, 0], predicted[m, 1], predicted[m, 2], predicted[m, 3] = x0, x1, x2, x3
            errors[0, m, place] = e
        x0 += gains[m, 0] * e
        x1 += gains[m, 1] * e
        x2 += gains[m, 2] * e
        x3 += gains[m, 3] * e
        x[m, 4] = keep * x[m, 4] + forget * gains[m, 8] * e * e
        if rated:
            e = rate - x1
            if len(predicted):
                errors[1, m, place] = e
            x0 += gains[m, 4] * e
            x1 += gains[m, 5] * e
            x2 += gains[m, 6] * e
            x3 += gains[m, 7] * e
            x[m, 5] = keep * x[m, 5] + forget * gains[m, 10] * e * e
        x[m, 0], x[m, 1], x[m, 2], x[m, 3] = x0, x1, x2, x3


@exact
def _error_place(memory, state, errors):
    """Return where the innovations of the sample go."""
    place = int(state[at.LAG_END])
    if place == errors.shape[3]:
        kept = int(memory[at.LENGTH])
        lines = errors.reshape((-1, place))
        for i in range(len(lines)):
            for t in range(kept):
                lines[i, t] = lines[i, place - kept + t]
        place = kept
    state[at.LAG_END] = place + 1
    return place


@_swift
def _advance(memory, n):
    """Do the step of the bank, and the smoothing, for the sample that has been admitted."""
    filters = int(memory[at.M])
    state = memory[at.STATE:at.TRIAL]
    dt, rated, delay = memory[at.STEP], memory[at.RATED] > 0.0, memory[at.DELAY]
    keep = math.exp(-dt / memory[at.WINDOW])
    state[at.SPAN] = span = keep * state[at.SPAN] + 1.0
    state[at.UNWEIGHED] += dt
    renew = state[at.UNWEIGHED] >= memory[at.RENEWAL]
    if renew:
        state[at.UNWEIGHED] = 0.0
    x = block(memory, at.FILTERS).reshape((n, filters, 8))
    gains = block(memory, at.GAINS).reshape((n, filters, 12))
    position, rate = block(memory, at.LAST), block(memory, at.RATES)
    out = block(memory, at.OUTBOX).reshape((4, n))
    states = block(memory, at.LAG_STATES).reshape((-1, n, filters, 4))
    errors = block(memory, at.LAG_ERRORS).reshape((2, n, filters, -1))
    taps = block(memory, at.LAG_TAPS).reshape((2, int(memory[at.TAP_SETS]), 4, -1))
    products = block(memory, at.LAG_PRODUCTS).reshape((filters, -1))
    head = count = end = 0
    onward = 0.0
    if delay > 0.0:
        stamps = block(memory, at.LAG_STAMPS)
        head, count = int(state[at.LAG_HEAD]), int(state[at.LAG_COUNT])
        memory[at.ONWARD] = stamps[head] - delay - stamps[head - count + 1]
        onward = memory[at.ONWARD] / TIME_UNIT
        end = _error_place(memory, state, errors) + 1
    for j in range(n):
        _step_filters(
            x[j], gains[j], position[j], rate[j] * TIME_UNIT, rated, dt / TIME_UNIT, 1.0 - keep,
            states[head, j] if delay > 0.0 else x[j, :0], errors[:, j], end - 1)
        if renew:
            _renew_weights(x[j], gains[j], span, rated)
        if delay == 0.0:
            a0, a1, a2, a3 = _weighted_mean(x[j], x[j])
        else:
            a0, a1, a2, a3 = _weighted_mean(states[head - count + 1, j], x[j])
            for c in range(2 if rated else 1):
                b0, b1, b2, b3 = _correction(
                    errors[c, j, :, end - count:end],
                    taps[c, j if len(taps[c]) > 1 else 0], x[j, :, 6], products)
                a0, a1, a2, a3 = a0 + b0, a1 + b1, a2 + b2, a3 + b3
        out[0, j] = a0 + onward * (a1 + onward * (a2 + onward * a3))
        out[1, j] = (a1 + onward * (2.0 * a2 + 3.0 * onward * a3)) / TIME_UNIT
        out[2, j] = (a2 + 3.0 * onward * a3) * 2.0 / TIME_UNIT**2
        out[3, j] = a3 * 6.0 / TIME_UNIT**3


@exact
def _accept(memory):
    """Let the sample that has been found in order enter the state."""
    for i in range(at.STATES):
        memory[at.STATE + i] = memory[at.TRIAL + i]
    last, fresh = block(memory, at.LAST), block(memory, at.FRESH)
    for j in range(len(last)):
        last[j] = fresh[j]


def compile_take(sources: int, cache: bool):
    """
    Return the function that takes a sample; it is compiled, or found, when it is first called.

    Parameters
    ----------
    sources:
        Enters the key under which machine code is found again: a checksum of all that it is
        made from, since Numba itself looks at this file only.
    cache:
        Whether to keep the machine code on disk.

    """
    @njit(error_model='numpy', cache=cache)
    def take(memory):
        """Take the sample in the inbox if it is in order; return whether it is."""
        sources     # names it, so that it enters the key
        n = int(memory[at.N])
        trial = memory[at.TRIAL:at.HEADER]
        for i in range(at.STATES):
            trial[i] = memory[at.STATE + i]
        if not in_order(memory, trial, n):
            return False
        trial[at.TAKEN] += 1.0
        _accept(memory)
        _advance(memory, n)
        return True

    return take

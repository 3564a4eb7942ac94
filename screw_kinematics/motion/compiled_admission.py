# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether a sample is in order for a steady run: guard, clock, pace, velocities; machine code."""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,misc"

from __future__ import annotations

import math

from numba import njit
import numpy as np

from . import pace, run_memory as at, sampling_clock, velocity_evidence, velocity_trust
from .velocity_block import NEIGHBOURS
from .velocity_block_loops import measure

_next_tick, _due, _decide = (
    njit(f) for f in (sampling_clock.next_tick, sampling_clock.due, sampling_clock.decide))
_follow = njit(pace.follow)
block = njit(at.block)
exact = njit(error_model='numpy')
_measure = exact(measure)
_forgetting, _weigh, _differ = (
    exact(f) for f in (velocity_evidence.forgetting, velocity_evidence.weigh,
                       velocity_evidence.differ))


@exact
def _moving(positions):
    """Return the number of joints that move."""
    moving = 0
    for j in range(positions.shape[1]):
        for i in range(1, len(positions)):
            if positions[i, j] != positions[0, j]:
                moving += 1
                break
    return moving


@exact
def _roughness(stamps, positions):
    """Do what `sampling_clock.roughness` does for one kind of stamps, but divide by joints."""
    samples, joints = positions.shape
    total = 0.0
    for w in range(samples - 4):
        t0, t1, t2, t3, t4 = (
            stamps[w], stamps[w + 1], stamps[w + 2], stamps[w + 3], stamps[w + 4])
        c1 = 1.0 / ((t1 - t0) * (t1 - t2) * (t1 - t3) * (t1 - t4))
        c2 = 1.0 / ((t2 - t0) * (t2 - t1) * (t2 - t3) * (t2 - t4))
        c3 = 1.0 / ((t3 - t0) * (t3 - t1) * (t3 - t2) * (t3 - t4))
        c4 = 1.0 / ((t4 - t0) * (t4 - t1) * (t4 - t2) * (t4 - t3))
        c0 = 1.0 / ((t0 - t1) * (t0 - t2) * (t0 - t3) * (t0 - t4))
        norm = c0 * c0 + c1 * c1 + c2 * c2 + c3 * c3 + c4 * c4
        for j in range(joints):
            q = positions[w, j]
            d = (c1 * (positions[w + 1, j] - q) + c2 * (positions[w + 2, j] - q)
                 + c3 * (positions[w + 3, j] - q) + c4 * (positions[w + 4, j] - q))
            total += d * d / norm
    return total / (samples - 4)


@exact
def _room(rows, fill, kept):
    """Return where the next row goes; when there is no more room, move the last to the front."""
    if fill < len(rows):
        return fill
    for i in range(kept):
        for j in range(rows.shape[1]):
            rows[i, j] = rows[fill - kept + i, j]
    return kept


@exact
def _admit_position(memory, trial, n):
    """Do what `SampleGuard.admit` does with a sample that is in order."""
    stamp, position = block(memory, at.INBOX)[1], block(memory, at.INBOX)[2:n + 2]
    last, fresh = block(memory, at.LAST), block(memory, at.FRESH)
    dt = stamp - trial[at.STAMP]
    if not (trial[at.SHORTEST] < dt and dt <= memory[at.MAX_GAP]):
        return False
    limit = memory[at.MAX_VELOCITY] * dt + memory[at.MAX_JUMP]
    wraps = block(memory, at.WRAPS)
    for j in range(n):
        fresh[j] = position[j]
        if memory[at.CONTINUOUS]:
            step = position[j] - last[j]
            if wraps[j]:
                step -= 2 * math.pi * np.rint(step / (2 * math.pi))
            fresh[j] = last[j] + step
        if not abs(fresh[j] - last[j]) <= limit:
            return False
    trial[at.STAMP] = stamp
    trial[at.SHORTEST] += 1e-3 * (1e-3 * dt - trial[at.SHORTEST])
    return True


@exact
def _admit_stamp(memory, trial, n):
    """Do what `SamplingClock` and `Pace` do; return whether the sample keeps the pace."""
    stamp = trial[at.STAMP]
    if memory[at.CLOCKED]:
        clock = trial[at.CLOCK:at.PACE]
        tick = _next_tick(clock, stamp)
        if math.isnan(tick):
            return False
        positions = block(memory, at.CLOCK_POSITIONS).reshape((-1, n))
        stamps = block(memory, at.CLOCK_STAMPS).reshape((-1, 2))
        fill = int(trial[at.CLOCK_END])
        _room(stamps, fill, sampling_clock.WINDOW)
        fill = _room(positions, fill, sampling_clock.WINDOW)
        fresh = block(memory, at.FRESH)
        for j in range(n):
            positions[fill, j] = fresh[j]
        stamps[fill, 0], stamps[fill, 1] = stamp, tick
        trial[at.CLOCK_END] = fill = fill + 1
        if _due(clock):
            first = fill - sampling_clock.WINDOW
            latest = positions[first:fill]
            moving = _moving(latest)
            _decide(clock, _roughness(stamps[first:fill, 0], latest) / max(moving, 1),
                    _roughness(stamps[first:fill, 1], latest) / max(moving, 1), moving)
        if clock[sampling_clock.REGULARISED]:
            stamp = tick
    dt = stamp - trial[at.INSTANT]
    reference = memory[at.REFERENCE]
    if not (0.5 * reference < dt and dt < 1.5 * reference):
        return False
    rhythm = trial[at.PACE:]
    _follow(rhythm, dt)
    trial[at.INSTANT] = stamp
    memory[at.STEP] = dt
    return rhythm[pace.REFERENCE] == reference


@exact
def _heeded(memory):
    """Whether the sample has velocities, and they are looked at."""
    return memory[at.TRUSTING] > 0.0 and block(memory, at.INBOX)[0] > 0.0


@exact
def _admit_velocity(memory, trial, n):
    """Do what `VelocityTrust.push` does but for judging; return whether the gains suit."""
    if not _heeded(memory):
        return memory[at.RATED] == 0.0
    velocity = block(memory, at.INBOX)[n + 2:]
    rates, gains = block(memory, at.RATES), block(memory, at.GAINS).reshape((n, -1, 12))
    stamps = block(memory, at.TRUST_STAMPS)
    positions = block(memory, at.TRUST_POSITIONS).reshape((-1, n))
    velocities = block(memory, at.TRUST_VELOCITIES).reshape((-1, n))
    fill = int(trial[at.TRUST_END])
    if fill and trial[at.INSTANT] - stamps[fill - 1] > velocity_trust.PAUSE:
        fill = 0
    stamps[fill] = trial[at.INSTANT]
    fresh = block(memory, at.FRESH)
    for j in range(n):
        positions[fill, j] = fresh[j]
        measured = abs(velocity[j]) < velocity_trust.LARGEST
        velocities[fill, j] = velocity[j] if measured else math.nan
        rates[j] = velocity[j] if measured else 0.0
        if gains[j, 0, 11] and not measured:
            return False
    trial[at.TRUST_END] = fill + 1
    return True


@exact
def judge(t, q, v, known, blocks):
    """Do what `velocity_evidence.judge` does."""
    memories = _forgetting(t, blocks)
    found, added = known.copy(), _measure(t, q, v)
    changed = False
    ratios = np.empty(q.shape[1])
    for j in range(q.shape[1]):
        ratios[j] = _weigh(found[:, j], added[:, j], memories)
        changed = changed or _differ(ratios[j], found[velocity_evidence.RATIO, j])
    if changed:
        found[velocity_evidence.RATIO] = ratios
    return found, changed


@exact
def _judge_velocities(memory, trial, n):
    """Judge the velocities if that is due; return whether what is used of them stays."""
    end = int(trial[at.TRUST_END])
    fresh = end - NEIGHBOURS
    if not _heeded(memory) or fresh < velocity_trust.BLOCK or not (
            trial[at.INSTANT] - trial[at.TRUST_JUDGED] >= velocity_trust.BLOCK_TIME
            or trial[at.TRUST_JUDGEMENTS] < velocity_trust.FIRST_BLOCKS
            or fresh >= velocity_trust.LONGEST_BLOCK):
        return True
    stamps = block(memory, at.TRUST_STAMPS)
    positions = block(memory, at.TRUST_POSITIONS).reshape((-1, n))
    velocities = block(memory, at.TRUST_VELOCITIES).reshape((-1, n))
    known = block(memory, at.TRUST_KNOWN).reshape((-1, n))
    found, changed = judge(stamps[:end], positions[:end], velocities[:end], known,
                           int(trial[at.TRUST_JUDGEMENTS]))
    if changed:
        return False
    for j in range(n):
        for row in range(len(known)):
            known[row, j] = found[row, j]
        for k in range(NEIGHBOURS):
            positions[k, j], velocities[k, j] = positions[fresh + k, j], velocities[fresh + k, j]
    for k in range(NEIGHBOURS):
        stamps[k] = stamps[fresh + k]
    trial[at.TRUST_JUDGEMENTS] += 1.0
    trial[at.TRUST_JUDGED] = trial[at.INSTANT]
    trial[at.TRUST_END] = NEIGHBOURS
    return True


@exact
def _admit_delay(memory, trial):
    """Find the sample before the delayed instant; return whether it is known."""
    if memory[at.DELAY] == 0.0:
        return True
    stamps = block(memory, at.LAG_STAMPS)
    head = int(trial[at.LAG_HEAD] + 1) % len(stamps)
    count = int(trial[at.LAG_COUNT]) + 1
    stamps[head] = trial[at.INSTANT]
    wanted = trial[at.INSTANT] - memory[at.DELAY] + 1e-9
    while count > 1 and stamps[head - count + 2] <= wanted:     # a negative place is one, too
        count -= 1
    trial[at.LAG_HEAD], trial[at.LAG_COUNT] = head, count
    return count <= memory[at.LENGTH] and stamps[head - count + 1] <= wanted


@exact
def in_order(memory, trial, n):
    """Try the sample in the inbox on a copy of the state; return whether it is in order."""
    return (_admit_position(memory, trial, n) and _admit_stamp(memory, trial, n)
            and _admit_velocity(memory, trial, n) and _admit_delay(memory, trial)
            and _judge_velocities(memory, trial, n))

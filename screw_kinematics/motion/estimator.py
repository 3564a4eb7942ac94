# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The default estimator: a self-tuning bank of filters, with an optional honest delay."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .compiled import announce, Kernels, load, ready
from .compiled_run import CompiledRun, Parts
from .filter_bank import BANDWIDTHS, FilterBank
from .fixed_lag import FixedLag, Parts as SmoothedParts
from .guarded_estimator import GuardedEstimator
from .joint_motion import Array, CovarianceSource, JointMotion
from .mixture import mixture_covariance
from .pace import Pace
from .sampling_clock import SamplingClock
from .steady_steps import Snapshot
from .velocity_trust import VelocityTrust
from .wiener_process import SCALE, transition
from ..errors import InvalidValueError

PHYSICAL = 1.0 / SCALE[:, None]
"""Physical state = scaled state * PHYSICAL."""

VELOCITY_CHOICES = ('auto', 'position-only')


class MotionEstimator(GuardedEstimator):
    """
    The self-tuning bank: filters of many bandwidths, weighted by how well each predicts.

    Nothing has to be tuned: noise level, encoder resolution, rate and the vigour of the motion
    are all read from the data, joint by joint.

    Parameters
    ----------
    n_joints:
        Number of joints.
    delay:
        0: estimates describe the latest sample. Above: they describe, and are stamped with, the
        instant `delay` s before it, and are several times as accurate (0.02 s is a good choice).
    velocity:
        ``'auto'``: the measured velocity is used per joint while it earns trust;
        ``'position-only'``: it is ignored.
    regularise:
        Whether jittering stamps of a periodic sampler may be replaced by regular ones.
    window:
        Memory of the filters' weights, s.
    keep_gains:
        Whether gains are kept once they have converged at a regular clock; the results are the
        same but for a small tolerance, at a third of the cost.
    **limits:
        `max_gap`, `max_velocity`, `continuous`, ... of `SampleGuard`.

    """

    def __init__(
        self, n_joints: int, delay: float = 0.0, velocity: str = 'auto', *,
        regularise: bool = True, window: float = 0.1, keep_gains: bool = True, **limits: Any,
    ) -> None:
        super().__init__(n_joints, delay=delay, **limits)
        if velocity not in VELOCITY_CHOICES:
            raise InvalidValueError(f'velocity is {velocity!r}; allowed: {VELOCITY_CHOICES}')
        if not window > 0.0:
            raise InvalidValueError(f'window is {window} s; allowed: more than 0')
        self.velocity = velocity
        self.keep_gains = keep_gains
        self._bank = self._make_bank(window)
        self._lag = FixedLag(self.delay) if self.delay > 0 else None
        self._bank.remember = self._lag is not None
        self._clock = SamplingClock() if regularise else None
        self._pace = Pace()
        self._trust = VelocityTrust(n_joints) if velocity == 'auto' else None
        self._instant = 0.0
        self._count = 0
        self._source: tuple[Snapshot, Array | None] | None = None    # None: the bank as it is
        self._run: CompiledRun | None = None
        self._use(ready())

    def _make_bank(self, window: float) -> FilterBank:
        return FilterBank(self.n_joints, BANDWIDTHS, window, self.keep_gains)

    def push(
        self, stamp: float, position: ArrayLike, velocity: ArrayLike | None = None
    ) -> bool:
        """Take one sample, as `update` does; return whether there is an estimate."""
        run = self._run
        if run is not None and (run.active or run.enter(self._instant)):
            if run.take(stamp, position, velocity):
                self.stamp = run.instant - self.delay
                return True
            self._leave_run()
        return super().push(stamp, position, velocity)

    def values(self) -> Sequence[float]:
        """Return positions, velocities, accelerations and jerks of that estimate in a row."""
        run = self._run
        return super().values() if run is None or not run.active else run.values()

    def motion(self) -> JointMotion:
        """Return the estimate that the latest sample led to; it stays as it is."""
        run = self._run
        if run is None or not run.active:
            return super().motion()
        onward = transition(run.onward) if self.delay else None
        return JointMotion(
            self.stamp, run.state(), partial(self._covariance, run.snapshot(), onward))

    def reset(self) -> None:
        """Forget every sample; the counts stay."""
        self._leave_run()
        self._bank.release()
        super().reset()

    def _leave_run(self) -> None:
        """Go on with the parts."""
        run = self._run
        if run is not None and run.active:
            onward = transition(run.onward) if self.delay else None
            self._instant, taken, self._state, snapshot = run.leave()
            self._count += taken
            self._source = snapshot, onward

    def _start(self, stamp: float, position: Array, velocity: Array | None) -> None:
        self._bank.start(position)
        self._count = 1
        self._instant = stamp
        for part in self._pace, self._clock, self._lag, self._trust:
            if part is not None:
                part.start()

    def _advance(
        self, stamp: float, dt: float, position: Array, velocity: Array | None
    ) -> Array | None:
        pace = self._pace
        if self._clock is not None:
            stamp = self._clock.push(stamp, position)
            dt = stamp - self._instant
            if not dt > 0.1 * pace.period:
                dt = 0.1 * (pace.period or dt)
                stamp = self._instant + dt
        self._instant = stamp
        self._count += 1
        pace.push(dt)
        ratio = None
        if self._trust is not None:
            velocity, ratio = self._trust.push(stamp, position, velocity)
        bank = self._bank
        step = bank.step(dt, pace.period, pace.reference, position, velocity, ratio)
        if step is None:
            if self._count < self.min_samples:
                return None
            self.stamp = stamp
            self._source = None
            return bank.state
        assert self._lag is not None
        self._lag.push(stamp, step, bank.steady)
        wanted = stamp - self.delay
        smoothed = self._lag.smooth(wanted, bank.weights, bank.mean)
        if smoothed is None or self._count < self.min_samples:
            return None
        time, mean, parts = smoothed
        onward = transition(wanted - time)
        state: Array = onward.dot(mean)
        state *= PHYSICAL
        self.stamp = wanted
        self._source = partial(_of_parts, bank.snapshot(), parts), onward
        return state

    def warm_up(self) -> None:
        """
        Compile the steady steps where Numba is installed; without, nothing changes.

        Once in a process is enough: estimators made afterwards use the compiled steps too.
        """
        kernels = load()
        if kernels is None:
            return
        self._use(kernels)
        if ready() is None:
            self._exercise()
            announce(kernels)

    def _use(self, kernels: Kernels | None) -> None:
        """Go on in machine code whenever the run of samples is steady, or not (None)."""
        self._leave_run()
        self._kernels = kernels
        self._run = None if kernels is None else CompiledRun(kernels, Parts(
            self._guard, self._pace, self._clock, self._trust, self._bank, self._lag), self.delay)

    def _exercise(self) -> None:
        """Run on made-up samples, so that the compiled functions are ready for the real ones."""
        random = np.random.default_rng(0)
        for delay in (0.0, 0.01):
            trial = MotionEstimator(1, delay)
            trial._use(self._kernels)
            time = 0.0
            while time < 1.0:
                time += 4e-3
                noise = random.normal(size=2)
                trial.update(time, 0.5 * time + 1e-5 * noise[:1], 0.5 + 1e-2 * noise[1:])

    @property
    def velocity_used(self) -> Array:
        """Whether the measured velocity of each joint enters the estimate, shape (n_joints,)."""
        ratio = None if self._trust is None else self._trust.ratio
        if ratio is None:
            return np.zeros(self.n_joints, bool)
        return np.isfinite(ratio)

    def doubts(self, joint_names: Sequence[str] | None = None) -> list[str]:
        """Return what is odd about the samples, as short sentences; joints by name or index."""
        self._leave_run()
        names: Iterable[object] = range(self.n_joints) if joint_names is None else joint_names
        found = []
        trust = self._trust
        if trust is not None:
            for what, joints in (
                    ('late or wrong', trust.lagging & ~trust.idle), ('always zero', trust.idle),
                    ('merely differenced from position', trust.differenced & ~trust.idle)):
                if joints.any():
                    listed = ', '.join(str(name) for name, odd in zip(names, joints) if odd)
                    found.append(f'measured velocity is {what}: joints {listed}')
        if self._clock is not None and self._clock.regularised:
            found.append('stamps jitter: replaced by a regular clock')
        if self._count > 100 and not self._pace.regular:
            found.append('sampling is irregular')
        return found

    def _covariance_source(self) -> CovarianceSource:
        return partial(self._covariance, *(self._source or (self._bank.snapshot(), None)))

    def _covariance(self, snapshot: Snapshot, onward: Array | None) -> Array:
        weights, noise, x, p = snapshot()
        return mixture_covariance(weights, self._noise(noise), x, p, onward)

    def _noise(self, estimated: Array) -> Array:
        """Return the variance that the unit of the filters' covariances stands for."""
        return estimated


def _of_parts(snapshot: Snapshot, parts: SmoothedParts) -> tuple[Array, Array, Array, Array]:
    """Return a snapshot with other states and covariances."""
    weights, noise, _, _ = snapshot()
    return weights, noise, *parts()


class FixedKalmanFilter(MotionEstimator):
    """
    One filter of the bank, of given bandwidth and noise; for comparison.

    Parameters
    ----------
    n_joints:
        Number of joints.
    delay:
        As in `MotionEstimator`.
    bandwidth:
        Bandwidth of the filter, Hz.
    position_noise:
        Standard deviation of the measured position, rad or m; it scales the covariance only,
        because the bandwidth fixes the ratio of process to measurement noise.
    **limits:
        `max_gap`, ... of `SampleGuard`.

    """

    def __init__(
        self, n_joints: int, delay: float = 0.0, *, bandwidth: float = 8.0,
        position_noise: float = 1e-5, **limits: Any,
    ) -> None:
        if not bandwidth > 0.0:
            raise InvalidValueError(f'bandwidth is {bandwidth} Hz; allowed: more than 0')
        if not position_noise > 0.0:
            raise InvalidValueError(f'position_noise is {position_noise}; allowed: more than 0')
        self.bandwidth = float(bandwidth)
        self.position_noise = float(position_noise)
        super().__init__(n_joints, delay, 'position-only', **limits)

    def _make_bank(self, window: float) -> FilterBank:
        return FilterBank(self.n_joints, {4: (self.bandwidth,)}, window, self.keep_gains)

    def _noise(self, estimated: Array) -> Array:
        return np.full_like(estimated, self.position_noise**2)

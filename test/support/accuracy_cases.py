# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Extreme motions, and how far floating point is from exact arithmetic on them.

The reference is exact differentiation with 40 digits of the very same joint screws and
numbers, so an error is one of evaluation and not of the model.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from screw_kinematics import Joint, SerialChain
from screw_kinematics.chains.inverse import InverseSolver
from support import exact, robots

QUANTITIES = ('pose', 'twist', 'accel', 'reduced_accel', 'jerk', 'snap')
EPSILON = np.finfo(float).eps
SMALLEST_NORMAL = np.finfo(float).tiny


@dataclass(frozen=True)
class Case:
    """A chain and its motion; ``bound`` is the library's largest error, in epsilons."""

    name: str
    chain: SerialChain
    motion: np.ndarray      # (5, dof): q and its derivatives
    bound: float

    @property
    def bounds(self) -> dict[str, float]:
        """
        Return the largest errors allowed.

        Compiled programs add constants and angles about parallel axes before they take a
        sine, which rounds the angle: that costs an epsilon for each radian turned.
        """
        turned = float(np.sum(np.abs(self.motion[0])))
        return {'library': self.bound * EPSILON,
                'compiled': self.bound * EPSILON * (1 + turned)}


def cases() -> list[Case]:
    """Return the extreme motions, with a plain one first."""
    panda, puma = robots.robot('panda'), robots.robot('puma560')
    plain = robots.random_motion(0, 7)
    wrist = robots.random_motion(1, 6)
    wrist[0, 4] = 1e-9                      # axes 4 and 6 all but coincide
    turned = robots.random_motion(2, 7)
    turned[0] *= 1e6
    spindles = robots.random_chain(3, ['helical', 'prismatic', 'revolute'] * 2)
    far = robots.random_motion(4, 6)
    far[0] *= 1e6
    slow = robots.random_motion(5, 7)
    slow[1:] *= 1e-9 ** np.arange(1, 5)[:, None]
    faint = robots.random_motion(6, 7) * 1e-9
    denormal = robots.random_motion(7, 7)
    denormal[1:] *= 1e-310
    still = 5e-324 * np.sign(robots.random_motion(8, 7))
    long = robots.random_chain(9, joints=40)
    return [
        Case('7R arm, ordinary motion', panda, plain, 50),
        Case('wrist 1e-9 rad from singular', puma, wrist, 50),
        Case('joint angles of 1e6 rad', panda, turned, 50),
        Case('screws and slides at 1e6', spindles, far, 50),
        Case('rates of 1e-9 rad/s, derivatives to match', panda, slow, 50),
        Case('angles and rates of 1e-9', panda, faint, 50),
        Case('denormal rates, 1e-310', panda, denormal, 50),
        Case('smallest numbers there are, 5e-324', panda, still, 50),
        Case('chain of 40 mixed joints', long, robots.random_motion(9, 40), 500),
        Case('robot 1000 km from the base frame', moved(panda, 1e6), plain, 10e6),
    ]


def moved(chain: SerialChain, distance: float) -> SerialChain:
    """Return the chain at some distance from its base frame."""
    shift = np.array([distance, -distance, distance]) / np.sqrt(3)
    home = np.array(chain.T_base_tool)
    home[:3, 3] += shift
    return SerialChain([Joint(j.name, j.kind, j.axis, j.point + shift) for j in chain.joints],
                       home)


def errors(case: Case) -> dict[str, dict[str, float]]:
    """
    Return the errors of the library and of the compiled program, by quantity.

    Each relative to the largest entry of the exact six-vector (of the exact pose: at least
    1), or to the smallest normal number where the exact one is smaller, so that one
    denormal step counts as one epsilon.
    """
    truth = exact.tip_motion(case.chain, *case.motion)
    expected = {
        'pose': truth.pose[:3], 'twist': truth.classical[0], 'accel': truth.classical[1],
        'reduced_accel': truth.reduced[1], 'jerk': truth.classical[2],
        'snap': truth.classical[3]}
    state = case.chain.state(*case.motion)
    library = {
        'pose': state.pose[:3], 'twist': state.velocity, 'accel': state.classical(2),
        'reduced_accel': state.reduced_acceleration, 'jerk': state.classical(3),
        'snap': state.classical(4)}
    program = case.chain.compile(outputs=QUANTITIES)(*case.motion)
    program['pose'] = np.column_stack([program['pose'][3:].reshape(3, 3), program['pose'][:3]])
    return {name: {key: relative_error(found[key], expected[key]) for key in QUANTITIES}
            for name, found in (('library', library), ('compiled', program))}


def relative_error(found: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest error relative to the largest entry."""
    assert np.all(np.isfinite(found))
    largest = max(np.max(np.abs(expected)), SMALLEST_NORMAL)
    return float(np.max(np.abs(found - expected)) / largest)


def inverse_errors() -> list[tuple[float, float, float]]:
    """
    Return distance to a singular posture, condition number, and error of joint rates.

    The rates solve for a twist at which the wrist's axes 4 and 6 nearly coincide; the
    reference solves the same floats with 40 digits.
    """
    puma = robots.robot('puma560')
    q, twist = robots.random_motion(10, 6, order=1)
    rows = []
    for distance in (1.0, 1e-2, 1e-4, 1e-6, 1e-8):
        q[4] = distance
        jacobian = puma.jacobian(q)
        rates = InverseSolver(exact=True).solve(jacobian, twist).rates
        solution = exact.CONTEXT.lu_solve(exact.CONTEXT.matrix(jacobian.tolist()),
                                          exact.CONTEXT.matrix(twist.tolist()))
        expected = np.array([float(x) for x in solution])
        rows.append((distance, float(np.linalg.cond(jacobian)),
                     relative_error(rates, expected)))
    return rows

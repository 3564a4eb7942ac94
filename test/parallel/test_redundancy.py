# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""More measurements, passive freedoms or constraints than needed."""
from functools import cache

import numpy as np
import pytest

from screw_kinematics import Joint, Mimic, SerialChain
from screw_kinematics.errors import ClosureError
from screw_kinematics.models.guarded_yaml import read_yaml
from screw_kinematics.models.model_file import robot_from_data
from screw_kinematics.parallel import ParallelManipulator
from support.parallel_geometry import moment
from support.robots import robot, ROBOTS as FILES


def planar(degrees):
    """Return a planar robot with a limb at each of these angles, as drawn at home."""
    limbs = []
    for k, angle in enumerate(np.radians(degrees), start=1):
        base, tip = (r * np.exp(1j * angle) for r in (0.5, 0.15))
        along = (tip - base) / abs(tip - base)
        x = (0.3**2 - 0.25**2 + 0.35**2) / (2 * 0.35)
        elbow = base + along * (x + 1j * np.sqrt(0.3**2 - x**2))
        limbs.append({'name': f'limb_{k}', 'joints': [
            {'name': f'{name}_{k}', 'axis': [0, 0, 1], 'point': [at.real, at.imag, 0]}
            for name, at in (('motor', base), ('elbow', elbow), ('wrist', tip))]})
    return robot_from_data(
        {'platform': {'xyz': [0, 0, 0]}, 'limbs': limbs,
         'actuated': [f'motor_{k}' for k in range(1, len(limbs) + 1)]}, 'test', 'planar')


@cache
def four():
    return planar([-150, -30, 90, 30])


def consistent_motion():
    """Return an exact motion of the platform and what the four motors do."""
    platform = moment('planar_3rrr', 0).platform
    manipulator = four()
    posture = manipulator.posture_at(platform.pose)
    return platform, posture, manipulator.inverse_rates(posture, *platform.reduced[:3])[0]


def test_consistent_measurements_give_the_exact_state():
    platform, posture, rates = consistent_motion()
    assert (four().dof, four().mobility, four().closure_tolerance) == (4, 3, 1e-2)
    found = four().state(posture.actuated, *rates)
    np.testing.assert_allclose(found.pose, platform.pose, atol=1e-12)
    for n in range(3):
        np.testing.assert_allclose(found.reduced[n], platform.reduced[n], atol=1e-11)


def misfit(manipulator, pose, joints):
    """Return the sum of squares of the limbs' distances from a platform pose."""
    values = dict(zip(manipulator.joint_names + manipulator.passive_joint_names, joints))
    total = 0.0
    for limb in manipulator.limbs:
        tip = limb.pose([values[n] for n in limb.joint_names])
        turn = pose[:3, :3] @ tip[:3, :3].T
        slip = (pose[:3, 3] - tip[:3, 3]) / manipulator.characteristic_length
        total += np.arctan2(turn[1, 0], turn[0, 0])**2 + slip @ slip
    return total


def test_contradicting_measurements_are_settled_by_least_squares():
    """No platform pose and passive angles nearby fit the limbs together better."""
    rng = np.random.default_rng(0)
    _, exact, _ = consistent_motion()
    q = exact.actuated + rng.normal(scale=1e-4, size=4)
    posture = four().posture(q, start=exact)
    least = misfit(four(), posture.pose, posture.joints)
    assert 1e-6 < np.sqrt(least) < 1e-2
    for _ in range(300):
        joints = posture.joints + np.concatenate([np.zeros(4), rng.normal(scale=1e-5, size=8)])
        pose = posture.pose.copy()
        angle = rng.normal(scale=1e-5)
        pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]] @ (
            pose[:2, :2])
        pose[:2, 3] += rng.normal(scale=1e-6, size=2)
        assert misfit(four(), pose, joints) > least * (1 - 1e-9)


def test_contradicting_rates_are_settled_by_least_squares():
    """Platform and passive rates at once, by least squares of all limbs' equations."""
    manipulator = four()
    _, posture, rates = consistent_motion()
    rate = rates[0] + np.random.default_rng(1).normal(scale=0.1, size=4)
    (twist,), (passive,) = manipulator.rates(posture, rate)
    values = dict(zip(manipulator.joint_names + manipulator.passive_joint_names,
                      posture.joints))
    scale = np.array([1, 1, 1, *[1 / manipulator.characteristic_length] * 3])
    rows, right = [], []
    for k, limb in enumerate(manipulator.limbs):
        columns = scale[:, None] * limb.jacobian([values[n] for n in limb.joint_names])
        row = np.zeros((6, 8 + 6))
        row[:, 2 * k:2 * k + 2] = columns[:, 1:]
        row[:, 8:] = -np.diag(scale)
        rows.append(row)
        right.append(-columns[:, 0] * rate[k])
    whole = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=1e-9)[0]
    np.testing.assert_allclose(np.concatenate([passive, twist]), whole, atol=1e-11)


def test_measurements_that_contradict_each_other_too_much():
    q = four().home.actuated + [0.2, 0, 0, 0]
    with pytest.raises(ClosureError, match="loop of limb 'limb_[1-4]' does not close"):
        four().posture(q)


@pytest.mark.parametrize('seed', range(3))
def test_legs_that_may_spin(seed):
    """With spherical joints at both ends a leg's spin is free, and of no effect."""
    file = FILES / 'stewart_6ups.yaml'
    data = read_yaml(str(file), file.read_bytes())
    for limb in data['limbs']:
        foot = limb['joints'][0]
        foot['kind'] = 'spherical'
        del foot['axes']
    spinning = robot_from_data(data, str(file), 'spinning')
    assert len(spinning.passive_joint_names) == 36
    exact = moment('stewart_6ups', seed)
    state = spinning.state(*exact.joints)
    np.testing.assert_allclose(state.pose, exact.platform.pose, atol=1e-12)
    for n in range(4):
        expected = exact.platform.reduced[n]
        np.testing.assert_allclose(
            state.reduced[n], expected, atol=1e-11 * max(1, np.max(np.abs(expected))))
    assert spinning.posture(exact.joints[0]).conditioning.direct == pytest.approx(
        robot('stewart_6ups').posture(exact.joints[0]).conditioning.direct, rel=1e-9)


def test_a_belt_between_the_cranks_takes_the_singularity_away():
    """A motor that drives both cranks holds a parallelogram in its flat posture too."""
    T = np.eye(4)
    T[:2, 3] = 1, 1
    linkage = ParallelManipulator([
        SerialChain([Joint(f'{side}_base', 'revolute', (0, 0, 1), (x, 0, 0), mimic=mimic),
                     Joint(f'{side}_tip', 'revolute', (0, 0, 1), (x, 1, 0))], T, name=side)
        for side, x, mimic in (('left', 0, None), ('right', 2, Mimic('left_base')))],
        ['left_base'])
    assert linkage.passive_joint_names == ('left_tip', 'right_tip')
    for angle in (-1.0, -np.pi / 2, -2.5):
        posture = linkage.posture([angle])
        np.testing.assert_allclose(
            posture.pose[:3, 3], [1 - np.sin(angle), np.cos(angle), 0], atol=1e-12)
        assert posture.conditioning.direct > 0.1
        (twist,), _ = linkage.rates(posture, [1.0])
        np.testing.assert_allclose(
            twist, [0, 0, 0, -np.cos(angle), -np.sin(angle), 0], atol=1e-12)

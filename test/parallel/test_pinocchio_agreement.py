# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Closed loops as Pinocchio has them: rigid constraints between the tips of the limbs.

Passive rates and accelerations come from Pinocchio's constraint Jacobian and its drift, by
least squares; the platform's motion is that of a frame. Nothing here knows reciprocal
screws.
"""
from functools import cache

import numpy as np
import pytest
from support.parallel_geometry import moment, ROBOTS
from support.robots import robot

pin = pytest.importorskip('pinocchio')
load = cache(robot)
cases = pytest.mark.parametrize(('name', 'seed'), [(n, s) for n in ROBOTS for s in range(3)])


class LoopModel:
    """All limbs as branches of one Pinocchio model, tied together at the platform."""

    def __init__(self, manipulator):
        self.model = pin.Model()
        self.names, self.sources, self.factors, tips = [], [], [], []
        for limb in manipulator.limbs:
            parent, here = 0, np.zeros(3)
            for joint in limb.joints:
                kind = pin.JointModelPrismaticUnaligned if joint.kind == 'prismatic' \
                    else pin.JointModelRevoluteUnaligned
                parent = self.model.addJoint(
                    parent, kind(*joint.axis), pin.SE3(np.eye(3), joint.point - here),
                    f'{limb.name}/{joint.name}')
                here = joint.point
                self.sources.append(joint.source)
                self.factors.append(1.0 if joint.mimic is None else joint.mimic.multiplier)
            T = limb.T_base_tool
            tips.append((parent, pin.SE3(T[:3, :3], T[:3, 3] - here)))
            self.model.addFrame(pin.Frame(limb.name, parent, tips[-1][1], pin.OP_FRAME))
        self.data = self.model.createData()
        self.constraints = [
            pin.RigidConstraintModel(pin.ContactType.CONTACT_6D, self.model, *tips[0], *tip,
                                     pin.LOCAL) for tip in tips[1:]]
        self.measured = list(manipulator.joint_names + manipulator.passive_joint_names)
        # From measured joints to all joints: followers repeat their source.
        self.spread = np.zeros((len(self.sources), len(self.measured)))
        for i, (source, factor) in enumerate(zip(self.sources, self.factors)):
            self.spread[i, self.measured.index(source)] = factor

    def jacobian(self, joints):
        """Return the constraints' Jacobian by the measured joints."""
        q = self.spread @ joints
        data = [constraint.createData() for constraint in self.constraints]
        pin.computeJointJacobians(self.model, self.data, q)
        rows = pin.getConstraintsJacobian(self.model, self.data, self.constraints, data)
        return rows @ self.spread

    def forward(self, *motion):
        """Set positions, rates and accelerations of the measured joints."""
        pin.forwardKinematics(
            self.model, self.data, *(self.spread @ values for values in motion))
        pin.updateFramePlacements(self.model, self.data)

    def tips(self, quantity, *arguments):
        """Return a quantity of the platform's frame as each limb has it."""
        first = self.model.nframes - len(self.constraints) - 1
        return [quantity(self.model, self.data, frame, *arguments)
                for frame in range(first, self.model.nframes)]

    def differences(self, quantity, *arguments):
        """Return a motion of limb 1's frame less that of each other limb's."""
        first, *others = [x.vector for x in self.tips(quantity, *arguments)]
        return np.concatenate([first - other for other in others])

    def axes_of(self, J, joints):
        """Return the axes in which the constraints compare velocities: read off."""
        rates = np.random.default_rng(0).normal(size=J.shape[1])
        self.forward(joints, rates, 0 * rates)
        for axes in (pin.WORLD, pin.LOCAL, pin.LOCAL_WORLD_ALIGNED):
            if np.allclose(J @ rates, self.differences(pin.getFrameVelocity, axes), atol=1e-9):
                return axes
        raise AssertionError('the constraints are no differences of velocities')


def angular_first(motion):
    """Return a Pinocchio motion in the order of this package."""
    return np.concatenate([motion.angular, motion.linear])


@cases
def test_loops_are_closed_as_pinocchio_sees_them(name, seed):
    manipulator = load(name)
    posture = manipulator.posture(moment(name, seed).joints[0])
    model = LoopModel(manipulator)
    still = np.zeros(len(posture.joints))
    model.forward(posture.joints, still, still)
    for frame in model.tips(lambda _, data, frame: data.oMf[frame]):
        np.testing.assert_allclose(frame.homogeneous, posture.pose, atol=1e-12)


@cases
def test_rates_and_accelerations_solve_the_constraints(name, seed):
    manipulator, joints = load(name), moment(name, seed).joints
    posture = manipulator.posture(joints[0])
    states, passive = manipulator.rates(posture, *joints[1:3])
    model, n = LoopModel(manipulator), manipulator.dof
    J = model.jacobian(posture.joints)
    by_passive = np.linalg.lstsq(J[:, n:], -J[:, :n] @ joints[1], rcond=1e-9)[0]
    np.testing.assert_allclose(passive[0], by_passive, atol=1e-10)

    rates = np.concatenate([joints[1], by_passive])
    np.testing.assert_allclose(J @ rates, 0, atol=1e-10)
    axes = model.axes_of(J, posture.joints)
    model.forward(posture.joints, rates, 0 * rates)
    drift = model.differences(pin.getFrameAcceleration, axes)
    second = np.linalg.lstsq(J[:, n:], -(J[:, :n] @ joints[2] + drift), rcond=1e-9)[0]
    np.testing.assert_allclose(passive[1], second, atol=1e-9)

    model.forward(posture.joints, rates, np.concatenate([joints[2], second]))
    state = manipulator.state(*joints[:3])
    for twist in model.tips(pin.getFrameVelocity, pin.LOCAL_WORLD_ALIGNED):
        np.testing.assert_allclose(state.velocity, angular_first(twist), atol=1e-10)
    for accel in model.tips(pin.getFrameClassicalAcceleration, pin.LOCAL_WORLD_ALIGNED):
        np.testing.assert_allclose(state.classical(2), angular_first(accel), atol=1e-9)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Closed loops as MuJoCo has them: welds between the tips of the limbs, and coupled joints.

Passive rates come from the Jacobian of MuJoCo's equality constraints, by least squares; the
platform's motion is that of sites. Nothing here knows reciprocal screws.
"""
from functools import cache

import numpy as np
import pytest
from support.parallel_geometry import moment, ROBOTS
from support.robots import robot

mujoco = pytest.importorskip('mujoco')
load = cache(robot)
cases = pytest.mark.parametrize(('name', 'seed'), [(n, s) for n in ROBOTS for s in range(3)])


def text(values):
    return ' '.join(repr(float(x)) for x in values)


def description(manipulator):
    """Return all limbs as branches of one model, drawn with all joints at zero."""
    branches, equalities = [], []
    for limb in manipulator.limbs:
        orientation = np.zeros(4)
        mujoco.mju_mat2Quat(orientation, limb.T_base_tool[:3, :3].ravel())
        inner = (f'<site name="{limb.name}" pos="{text(limb.T_base_tool[:3, 3])}" '
                 f'quat="{text(orientation)}"/>')
        for joint in reversed(limb.joints):
            kind = 'slide' if joint.kind == 'prismatic' else 'hinge'
            inner = (f'<body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
                     f'<joint name="{joint.name}" type="{kind}" axis="{text(joint.axis)}" '
                     f'pos="{text(joint.point)}"/>{inner}</body>')
            if joint.mimic is not None:
                equalities.append(
                    f'<joint joint1="{joint.name}" joint2="{joint.source}" '
                    f'polycoef="{text([joint.mimic.offset, joint.mimic.multiplier, 0, 0, 0])}"/>')
        branches.append(inner)
    first, *others = manipulator.limbs
    equalities += [f'<weld site1="{first.name}" site2="{limb.name}"/>' for limb in others]
    return (f'<mujoco><compiler autolimits="false"/><option gravity="0 0 0"/><worldbody>'
            f'{"".join(branches)}</worldbody><equality>{"".join(equalities)}</equality></mujoco>')


class LoopModel:
    """The model, and one posture of it with rates of all joints."""

    def __init__(self, manipulator, joints, rates=None, accelerations=None):
        self.model = mujoco.MjModel.from_xml_string(description(manipulator))
        self.data = mujoco.MjData(self.model)
        names = manipulator.joint_names + manipulator.passive_joint_names
        # From measured joints to all joints: followers repeat their source.
        self.spread = np.zeros((self.model.nv, len(names)))
        for joint in manipulator.joints:
            factor = 1.0 if joint.mimic is None else joint.mimic.multiplier
            row = self.model.joint(joint.name).dofadr[0]
            self.spread[row, names.index(joint.source)] = factor
        self.data.qpos[:] = self.spread @ joints
        if rates is not None:
            self.data.qvel[:] = self.spread @ rates
        mujoco.mj_forward(self.model, self.data)
        if accelerations is not None:
            self.data.qacc[:] = self.spread @ accelerations
            mujoco.mj_rnePostConstraint(self.model, self.data)

    @property
    def jacobian(self):
        """Return the equality constraints' Jacobian by the measured joints."""
        rows = np.array(self.data.efc_J).reshape(-1, self.model.nv)[:self.data.ne]
        return rows @ self.spread

    def site(self, limb, function):
        """Return a motion of a limb's tip, angular first, in axes of the base."""
        out = np.zeros(6)
        function(self.model, self.data, mujoco.mjtObj.mjOBJ_SITE,
                 self.model.site(limb.name).id, out, 0)
        return out


@cases
def test_loops_are_closed_as_mujoco_sees_them(name, seed):
    manipulator = load(name)
    posture = manipulator.posture(moment(name, seed).joints[0])
    model = LoopModel(manipulator, posture.joints)
    assert model.data.ne >= 6 * (len(manipulator.limbs) - 1)
    np.testing.assert_allclose(model.data.efc_pos[:model.data.ne], 0, atol=1e-12)
    for limb in manipulator.limbs:
        site = model.data.site(limb.name)
        np.testing.assert_allclose(site.xpos, posture.pose[:3, 3], atol=1e-12)
        np.testing.assert_allclose(site.xmat.reshape(3, 3), posture.pose[:3, :3], atol=1e-12)


@cases
def test_passive_rates_solve_the_constraints(name, seed):
    manipulator, joints = load(name), moment(name, seed).joints
    posture = manipulator.posture(joints[0])
    _, passive = manipulator.rates(posture, joints[1])
    n, J = manipulator.dof, LoopModel(manipulator, posture.joints).jacobian
    found, *_ = np.linalg.lstsq(J[:, n:], -J[:, :n] @ joints[1], rcond=1e-9)
    np.testing.assert_allclose(passive[0], found, atol=1e-9)


@cases
def test_every_tip_moves_as_the_platform(name, seed):
    manipulator, joints = load(name), moment(name, seed).joints
    posture = manipulator.posture(joints[0])
    state = manipulator.state(*joints[:3])
    _, passive = manipulator.rates(posture, *joints[1:3])
    motion = [np.concatenate(pair) for pair in zip(joints[1:3], passive)]
    model = LoopModel(manipulator, posture.joints, *motion)
    for limb in manipulator.limbs:
        np.testing.assert_allclose(
            model.site(limb, mujoco.mj_objectVelocity), state.velocity, atol=1e-10)
        np.testing.assert_allclose(
            model.site(limb, mujoco.mj_objectAcceleration), state.classical(2), atol=1e-10)

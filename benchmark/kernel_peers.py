# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Ways to compute pose, twist and classical acceleration of a Panda's hand, one sample a call.

Each takes the robot's URDF without its meshes, and returns a function of joint positions,
velocities and accelerations, arrays of shape (7,). Its result is position (3), rotation
(3 x 3), twist (6) and acceleration (6), in base axes at the hand's origin, as the library
has them: those of LINEAR_FIRST have the linear part before the angular one. Where a library
gives less, it is that much of them.
"""
from collections.abc import Callable
import tempfile
from typing import Any

import numpy as np

from screw_kinematics import SerialChain

from .node.robot import BASE, JOINTS

TIP = 'panda_hand_tcp'
LINEAR_FIRST = ('Pinocchio', 'kinpy', 'Robotics Toolbox')
FINGERS = ['panda_finger_joint1', 'panda_finger_joint2']

Sample = Callable[[Any, Any, Any], tuple[Any, ...]]


def pinocchio(urdf: str) -> Sample:
    """Pinocchio's C++, called from Python."""
    import pinocchio as pin
    full = pin.buildModelFromXML(urdf)
    model = pin.buildReducedModel(full, [full.getJointId(f) for f in FINGERS],
                                  pin.neutral(full))
    data, tip = model.createData(), model.getFrameId(TIP)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def sample(q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        pin.forwardKinematics(model, data, q, qd, qdd)
        pose = pin.updateFramePlacement(model, data, tip)
        twist = pin.getFrameVelocity(model, data, tip, axes)
        accel = pin.getFrameClassicalAcceleration(model, data, tip, axes)
        return pose.translation, pose.rotation, twist.vector, accel.vector

    return sample


def textbook(chain: SerialChain) -> Sample:
    """Product of exponentials with 4x4 and 6x6 matrices, as textbooks have it."""
    def hat(w: Any) -> Any:
        return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])

    def exponential(screw: Any, angle: float) -> Any:
        W = hat(screw[:3])
        W2 = W @ W
        T = np.eye(4)
        T[:3, :3] += np.sin(angle) * W + (1 - np.cos(angle)) * W2
        T[:3, 3] = (angle * np.eye(3) + (1 - np.cos(angle)) * W
                    + (angle - np.sin(angle)) * W2) @ screw[3:]
        return T

    def adjoint(T: Any) -> Any:
        R = T[:3, :3]
        return np.block([[R, np.zeros((3, 3))], [hat(T[:3, 3]) @ R, R]])

    def ad(V: Any) -> Any:
        return np.block([[hat(V[:3]), np.zeros((3, 3))], [hat(V[3:]), hat(V[:3])]])

    home = chain.screws(np.zeros(chain.dof), 'base')

    def sample(q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        T, V, A = np.eye(4), np.zeros(6), np.zeros(6)
        for screw, angle, rate, acceleration in zip(home, q, qd, qdd):
            present = adjoint(T) @ screw
            A = A + acceleration * present + rate * ad(V) @ present
            V = V + rate * present
            T = T @ exponential(screw, angle)
        T = T @ chain.T_base_tool
        p = T[:3, 3]
        v = V[3:] + np.cross(V[:3], p)
        a = A[3:] + np.cross(A[:3], p) + np.cross(V[:3], v)
        return p, T[:3, :3], np.concatenate([V[:3], v]), np.concatenate([A[:3], a])

    return sample


def mujoco(urdf: str) -> Sample:
    """MuJoCo: what its forward dynamics does for positions, velocities, accelerations."""
    import mujoco as mj
    tag = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'
    model = mj.MjModel.from_xml_string(urdf.replace('</robot>', tag + '</robot>'))
    model.opt.gravity[:] = 0
    data = mj.MjData(model)
    tip = mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, TIP)
    arm = np.array([model.joint(name).dofadr[0] for name in JOINTS])
    twist, accel = np.empty(6), np.empty(6)

    def sample(q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        data.qpos[arm], data.qvel[arm], data.qacc[arm] = q, qd, qdd
        mj.mj_kinematics(model, data)
        mj.mj_comPos(model, data)
        mj.mj_comVel(model, data)
        mj.mj_rnePostConstraint(model, data)
        mj.mj_objectVelocity(model, data, mj.mjtObj.mjOBJ_XBODY, tip, twist, 0)
        mj.mj_objectAcceleration(model, data, mj.mjtObj.mjOBJ_XBODY, tip, accel, 0)
        return data.xpos[tip], data.xmat[tip], twist, accel

    return sample


def drake(urdf: str) -> Sample:
    """Drake's MultibodyPlant, fingers locked at zero."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import JacobianWrtVariable
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(urdf, 'urdf')
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(BASE))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    tip, world = plant.GetFrameByName(TIP), plant.world_frame()
    arm = np.array([plant.GetJointByName(name).velocity_start() for name in JOINTS])
    state = np.zeros(plant.num_positions() + plant.num_velocities())
    rates = np.zeros(plant.num_velocities())

    def sample(q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        state[arm], state[plant.num_positions() + arm], rates[arm] = q, qd, qdd
        plant.SetPositionsAndVelocities(context, state)
        pose = tip.CalcPoseInWorld(context)
        twist = tip.CalcSpatialVelocityInWorld(context)
        jacobian_rates = plant.CalcBiasSpatialAcceleration(
            context, JacobianWrtVariable.kV, tip, np.zeros(3), world, world)
        jacobian = plant.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, tip, np.zeros(3), world, world)
        return (pose.translation(), pose.rotation().matrix(), twist.get_coeffs(),
                jacobian_rates.get_coeffs() + jacobian @ rates)

    return sample


def kinpy(urdf: str) -> Sample:
    """Kinpy: pose and twist by its Jacobian; it has no accelerations."""
    import kinpy as kp
    chain = kp.build_serial_chain_from_urdf(urdf, TIP, BASE)

    def sample(q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        pose = chain.forward_kinematics(q)
        return pose.pos, pose.rot_mat, chain.jacobian(q) @ qd

    return sample


def roboticstoolbox(urdf: str) -> Sample:
    """Robotics Toolbox for Python: Jacobian and its time derivative."""
    import roboticstoolbox as rtb
    with tempfile.NamedTemporaryFile('w', suffix='.urdf') as file:
        file.write(urdf)
        file.flush()
        robot = rtb.Robot.URDF(file.name).ets(start=BASE, end=TIP)

    def sample(q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        pose = robot.eval(q)
        jacobian = robot.jacob0(q)
        rates = np.tensordot(robot.hessian0(q, J0=jacobian), qd, (0, 0))
        return pose[:3, 3], pose[:3, :3], jacobian @ qd, jacobian @ qdd + rates @ qd

    return sample

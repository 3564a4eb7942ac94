# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A six-axis arm with a force sensor and a payload, simulated by MuJoCo."""
import mujoco
import numpy as np
from screw_kinematics.pipeline.payload import Payload

JOINTS = [('pan', (0, 0, 0.16), (0, 0, 1)), ('lift', (0, 0.13, 0), (0, 1, 0)),
          ('elbow', (0.42, 0, 0), (0, 1, 0)), ('wrist_1', (0.39, -0.1, 0), (0, 1, 0)),
          ('wrist_2', (0, 0.1, -0.1), (0, 0, -1)), ('wrist_3', (0, 0.05, 0), (0, 1, 0))]
NAMES = [name for name, _, _ in JOINTS]
FRAME, SENSOR = 'ft_frame', ((0.0, 0.04, 0.02), (0.3, -0.2, 1.1))   # in the last link; xyz, rpy
BODY = Payload(1.8, (0.012, -0.02, 0.075), (0.011, 0.001, -0.0015, 0.009, 0.0008, 0.006))
BIAS = np.array([4.0, -2.5, 7.0, 0.3, -0.2, 0.1])
TICK = 2 * np.pi / 2**17        # of the encoders [rad]
LAG = 0.005                     # of the measured velocities [s]
NOISE = np.array([0.1] * 3 + [0.004] * 3)      # of the sensor [N, N m]


def urdf():
    """Return the arm, whose tip is `tool0`; the sensor is beside it on the last link."""
    links, joints, parent = ['<link name="base_link"/>'], [], 'base_link'
    for name, xyz, axis in JOINTS:
        links.append(f'<link name="{name}_link"/>')
        joints.append(
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{name}_link"/><origin xyz="{_row(xyz)}"/><axis xyz="{_row(axis)}"/>'
            '<limit lower="-9" upper="9" effort="9" velocity="9"/></joint>')
        parent = f'{name}_link'
    for frame, (xyz, rpy) in ((FRAME, SENSOR), ('tool0', ((0, 0.09, 0), (-1.57, 0, 0)))):
        links.append(f'<link name="{frame}"/>')
        joints.append(f'<joint name="to_{frame}" type="fixed"><parent link="{parent}"/>'
                      f'<child link="{frame}"/><origin xyz="{_row(xyz)}" rpy="{_row(rpy)}"/>'
                      '</joint>')
    return f'<robot name="loaded">{"".join(links + joints)}</robot>'


def _row(values):
    return ' '.join(map(str, values))


def _model():
    xx, xy, xz, yy, yz, zz = BODY.inertia
    xyz, rpy = SENSOR
    body = (f'<body pos="{_row(xyz)}" euler="{_row(rpy)}"><site name="sensor"/>'
            f'<inertial mass="{BODY.mass}" pos="{_row(BODY.center)}" '
            f'fullinertia="{xx} {yy} {zz} {xy} {xz} {yz}"/></body>')
    for name, at, axis in reversed(JOINTS):
        body = (f'<body pos="{_row(at)}"><joint name="{name}" axis="{_row(axis)}"/>'
                f'<inertial mass="1" pos="0 0 0" diaginertia="0.01 0.01 0.01"/>{body}</body>')
    return mujoco.MjModel.from_xml_string(
        '<mujoco><compiler angle="radian" eulerseq="XYZ"/>'
        f'<option gravity="0 0 -9.80665"/><worldbody>{body}</worldbody>'
        '<sensor><force site="sensor"/><torque site="sensor"/></sensor></mujoco>')


def motion(t, speed=1.8):
    """Return positions, velocities and accelerations of the joints at times [s]."""
    t = np.asarray(t, float)[:, None]
    k = np.arange(6)
    q = qd = qdd = 0.0
    for part in range(3):
        amplitude = (0.5, 0.22, 0.1)[part] * np.array([1, 0.6, 0.7, 1, 1, 1.2])
        w = speed * (1.1 + 1.7 * part) * (1 + 0.13 * k)
        phase = 0.7 * k + 1.3 * part
        q = q + amplitude * np.sin(w * t + phase)
        qd = qd + amplitude * w * np.cos(w * t + phase)
        qdd = qdd - amplitude * w**2 * np.sin(w * t + phase)
    return q + np.array([0, -1.0, 1.2, -0.3, 0.5, 0]), qd, qdd


def wrenches(t, speed=1.8, rng=None):
    """Return the wrench that the sensor shows at times [s], shape (N, 6): load, bias and noise."""
    model = _model()
    data = mujoco.MjData(model)
    rows = []
    for q, qd, qdd in zip(*motion(t, speed)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(model, data)
        rows.append(data.sensordata.copy())
    # MuJoCo: what the parent exerts on the child.
    values = BIAS - np.array(rows)
    return values if rng is None else values + NOISE * rng.normal(size=values.shape)


def readings(t, speed=1.8):
    """Return what encoders and drives say at times [s] of constant step: position, velocity."""
    q, qd, _ = motion(t, speed)
    share = (t[1] - t[0]) / LAG
    lagging = np.array(qd)
    for k in range(1, len(t)):
        lagging[k] = lagging[k - 1] + (qd[k] - lagging[k - 1]) * share
    return np.round(q / TICK) * TICK, lagging

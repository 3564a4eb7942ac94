# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""An arm, its motion, and samples of it for a pipeline."""
import numpy as np
from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import Reason
from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.pipeline.kinematics import Kinematics
from screw_kinematics.pipeline.robot_pipeline import RobotPipeline
from screw_kinematics.pipeline.robot_program import OneTip
from screw_kinematics.pipeline.settings import MotionSettings

MS = 1_000_000
START = 1_700_000_000_000_000_000
NAMES = ('q1', 'q2', 'q3')
MEASURED = MotionSettings(velocity_source='measured')
ARM = SerialChain([
    Joint('q1', 'revolute', axis=(0, 0, 1)),
    Joint('q2', 'revolute', axis=(0, 1, 0), point=(0.1, 0, 0.3)),
    Joint('q3', 'prismatic', axis=(1, 0, 0))],
    [[1, 0, 0, 0.8], [0, 1, 0, 0], [0, 0, 1, 0.3], [0, 0, 0, 1]])


def joints(t):
    """Return positions, velocities and accelerations of a smooth motion."""
    w, a = np.array([1.0, 1.5, 0.7]), np.array([0.4, 0.3, 0.1])
    return a * np.sin(w * t), a * w * np.cos(w * t), -a * w * w * np.sin(w * t)


def make(settings=MEASURED, outputs=('twist',), covariance=False, **options):
    """Return a pipeline of the arm that wants some outputs."""
    pipeline = RobotPipeline(ARM.joint_names, settings, **options)
    pipeline.activate(Kinematics(OneTip(ARM.compile(outputs=outputs)), covariance))
    return pipeline


def take(pipeline, stamp_ns, names, position, velocity=()):
    """Give a sample; return the state it leads to, or the reason."""
    return pipeline.take(JointSample(
        stamp_ns, tuple(names), tuple(map(float, position)), tuple(map(float, velocity))))


def feed(pipeline, n, start=START, names=NAMES, period=2 * MS, velocity=True):
    """Give n samples of the motion; return the instants and values of the outputs."""
    pick = [NAMES.index(name) for name in names]
    outputs = []
    for k in range(n):
        q, qd, _ = joints(k * period * 1e-9)
        state = take(pipeline, start + k * period, names, q[pick], qd[pick] if velocity else ())
        if not isinstance(state, Reason):
            outputs.append((state.stamp_ns, state.values))
    return outputs


def assert_balanced(pipeline):
    account = pipeline.account
    assert account.received == account.used + account.refused.total()

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The wrench without weight and inertia of the load, over DDS."""
import numpy as np
import pytest

pytest.importorskip('mujoco')

from geometry_msgs.msg import TwistStamped, WrenchStamped    # noqa: E402
from support import loaded_arm as arm    # noqa: E402
from support.rig import (    # noqa: E402
    joint_state, RELIABLE_INPUT, running, stamp_ns, wrench_stamped)

START, STEP = 10**11, 4_000_000
PARAMETERS = {
    'robots': ['arm'], 'diagnostics_rate': 20.0,
    'qos_overrides': {f'/{topic}': {'subscription': RELIABLE_INPUT}
                      for topic in ('joint_states', 'ft/wrench')},
    'arm': {'description': arm.urdf(), 'tip_frame': 'tool0', 'stale_timeout': 30.0,
            'outputs': ['twist', 'compensated_wrench'], 'wrench_topic': 'ft/wrench',
            'wrench_bias': arm.BIAS.tolist(), 'estimator': {'delay': 0.02},
            'payload': {'mass': arm.BODY.mass, 'center': list(arm.BODY.center),
                        'inertia': list(arm.BODY.inertia)}}}


def values_of(message):
    """Return force and torque of a message."""
    force, torque = message.wrench.force, message.wrench.torque
    return [force.x, force.y, force.z, torque.x, torque.y, torque.z]


class Motion:
    """Joint states and wrenches of the arm, as long as they are wanted."""

    def __init__(self, rig):
        self.rig, self.k = rig, 0
        t = np.arange(0, 24, STEP * 1e-9)
        self.q, self.qd = arm.readings(t)
        self.shown = arm.wrenches(t, rng=np.random.default_rng(1))
        self.states, self.wrenches = (
            rig.publisher('joint_states'),
            rig.node.create_publisher(WrenchStamped, 'ft/wrench', 100))

    def play(self, until, frame=arm.FRAME):
        """Publish until a condition holds."""
        while not until():
            k = self.k = self.k + 1
            assert k < len(self.q), self.rig.status('arm')
            stamp = START + k * STEP
            self.states.publish(joint_state(arm.NAMES, stamp, self.q[k], self.qd[k]))
            self.wrenches.publish(wrench_stamped(stamp, self.shown[k], frame))
            self.rig.spin(0.004)


def test_compensated_wrench(context, tmp_path):
    with running(context, tmp_path, PARAMETERS) as rig:
        motion = Motion(rig)
        twists = rig.listen('arm/twist', TwistStamped)
        motion.play(lambda: len(twists) > 50)
        # Nobody listens to the wrench: it is not even received.
        assert rig.node.count_subscribers('ft/wrench') == 0
        assert 'ft/wrench wrenches' in rig.status('arm')[2]
        assert rig.status('arm')[2]['ft/wrench wrenches'] == '0'

        got = rig.listen('arm/compensated_wrench', WrenchStamped)
        motion.play(lambda: len(got) > 300)
        settled = got[100:300]
        left = np.array([values_of(m) for m in settled])
        force = np.sqrt((left[:, :3]**2).sum(axis=1).mean())
        torque = np.sqrt((left[:, 3:]**2).sum(axis=1).mean())
        print(f'\nleft of force {force:.3f} N, of torque {torque:.4f} N m')
        assert force < 0.4 and torque < 0.02
        assert {m.header.frame_id for m in settled} == {arm.FRAME}
        # Each is stamped with an instant of the joint states, the delay before the latest one.
        assert all((stamp_ns(m) - START) % STEP == 0 for m in settled)
        rig.wait(lambda: rig.status('arm')[2].get('ft/wrench compensated', '0') != '0')
        assert 'wrench' not in rig.status('arm')[1], rig.status('arm')

        # A load that is set anew weighs at once.
        assert rig.set_parameters(arm__payload__mass=0.0).successful
        n = len(got)
        motion.play(lambda: len(got) > n + 150)
        weight = np.array([values_of(m) for m in got[n + 100:]])[:, :3]
        assert np.linalg.norm(weight.mean(axis=0)) > 5
        for name, value, text in (
                ('payload__mass', -1.0, "arm.payload.mass out of range"),
                ('payload__inertia', [1.0, 0.0, 0.0, 1.0, 0.0, 3.0], 'larger than the two others'),
                ('wrench_frame', 'elbow_link', 'a link that is fixed to the tip frame')):
            result = rig.set_parameters(**{f'arm__{name}': value})
            assert not result.successful and text in result.reason

        # What is wrong with the stream is one line.
        line = "frame_id is 'hand'; allowed: ft_frame, or name the link in arm.wrench_frame"
        motion.play(lambda: line in rig.status('arm')[1], frame='hand')
        assert int(rig.status('arm')[2]['ft/wrench refused frame_not_fixed_to_tip']) > 0
        rig.wait(lambda: f'wrenches of arm: frame_not_fixed_to_tip ({line})'
                 in rig.log.read_text())


def test_a_tip_has_a_sensor_of_its_own(context, tmp_path):
    arm_settings = dict(PARAMETERS['arm'])
    own = {key: arm_settings.pop(key) for key in ('wrench_topic', 'wrench_bias', 'payload')}
    del arm_settings['tip_frame']
    parameters = {**PARAMETERS, 'arm': {
        **arm_settings, 'outputs': ['twist'], 'tips': ['wrist_1_link', arm.FRAME],
        arm.FRAME: {**own, 'outputs': ['compensated_wrench']}}}
    with running(context, tmp_path, parameters) as rig:
        motion = Motion(rig)
        got = rig.listen(f'arm/{arm.FRAME}/compensated_wrench', WrenchStamped)
        motion.play(lambda: len(got) > 250)
        left = np.array([values_of(m) for m in got[100:250]])
        assert np.sqrt((left[:, :3]**2).sum(axis=1).mean()) < 0.4
        assert {m.header.frame_id for m in got} == {arm.FRAME}


def test_without_a_sensor_one_line_says_so(context, tmp_path):
    with running(context, tmp_path, PARAMETERS) as rig:
        rig.listen('arm/compensated_wrench', WrenchStamped)
        states = rig.publisher('joint_states')
        t = np.arange(0, 40, STEP * 1e-9)
        q, qd = arm.readings(t)
        for k in range(len(t)):
            states.publish(joint_state(arm.NAMES, START + k * STEP, q[k], qd[k]))
            rig.spin(0.004)
            if 'ft/wrench: no wrench has come' in rig.status('arm')[1]:
                return
        raise AssertionError(rig.status('arm'))

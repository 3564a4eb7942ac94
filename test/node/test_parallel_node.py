# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node on a simulated Gough-Stewart platform, over DDS."""
import itertools
from pathlib import Path

from geometry_msgs.msg import AccelStamped, PoseStamped, TwistStamped
import numpy as np
import pytest
from screw_kinematics import models
from screw_kinematics.errors import ParameterError
from screw_kinematics.pipeline.robot_model import check_outputs
from sensor_msgs.msg import JointState
from support import rig as rigs, simulated_stewart as simulated
from support.rig import joint_state, RPR, running, six, stamp_ns

STEWART = 'package://screw_kinematics/config/robots/stewart_6ups.yaml'
PERIOD = 2_000_000
START = 100_000_000_000
SAMPLES = 1000
TYPES = {'twist': TwistStamped, 'accel': AccelStamped, 'pose': PoseStamped,
         'passive_joint_states': JointState}


def content(message):
    """Return the six-vector of a message."""
    return six(message.twist if hasattr(message, 'twist') else message.accel)


@pytest.fixture(scope='module')
def stream(module_context, tmp_path_factory):
    """Run the node over two seconds of motion, then bad samples, then good ones."""
    parameters = {
        'robots': ['hexapod'],
        'hexapod': {'description': STEWART, 'outputs': list(TYPES),
                    'estimator': {'kind': 'kalman'}}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rigs, 'CODE', f'import runpy; runpy.run_path('
                      f'{str(Path(simulated.__file__))!r}, run_name="__main__")')
        with running(module_context, tmp_path_factory.mktemp('stewart'), parameters) as rig:
            received = {name: rig.listen(f'hexapod/{name}', kind)
                        for name, kind in TYPES.items()}
            publisher = rig.publisher('joint_states')
            rig.wait_until_serving('hexapod', ['pose', 'twist', 'accel', 'passive_joint_states'])

            def send(stamp, positions):
                publisher.publish(joint_state(simulated.LEGS, stamp, positions))

            before = itertools.count(START - 20_000 * PERIOD, PERIOD)

            def answered():     # the program is made in the background
                stamp = next(before)
                send(stamp, simulated.legs(stamp * 1e-9)[0])
                return all(received.values())
            rig.wait(answered)

            def answered_up_to(stamp):
                return all(stamp_ns(messages[-1]) >= stamp for messages in received.values())

            last = START + (SAMPLES - 1) * PERIOD
            for stamp in range(START, last + 1, PERIOD):
                send(stamp, simulated.legs(stamp * 1e-9)[0])
                # So that no queue is ever full, however slow the machine is.
                rig.wait(lambda: answered_up_to(stamp - 5 * PERIOD))
            rig.wait(lambda: answered_up_to(last))
            report = {}
            # It runs; this test's stamps are of no clock.
            rig.wait(lambda: rig.status('hexapod', 'stamps are not of this clock')[2])
            report['good'] = rig.status('hexapod', 'stamps are not of this clock')

            bad = simulated.legs(last * 1e-9)[0] + [1.0, 0, 0, 0, 0, 0]
            stamps = itertools.count(last + PERIOD, PERIOD)

            def refused():      # until a report has nothing else
                send(next(stamps), bad)
                return rig.status('hexapod')[0] == b'\2'
            rig.wait(refused)
            report['bad'] = rig.status('hexapod')
            again = next(stamps)
            send(again, simulated.legs(again * 1e-9)[0])
            rig.wait(lambda: answered_up_to(again))
            yield {name: [m for m in messages if stamp_ns(m) >= START]
                   for name, messages in received.items()}, report, again


def test_every_sample_has_its_states(stream):
    messages, _, again = stream
    expected = [*(START + k * PERIOD for k in range(SAMPLES)), again]
    for name in TYPES:
        assert [stamp_ns(m) for m in messages[name]] == expected


def test_states_are_those_of_the_exact_motion(stream):
    messages, *_ = stream
    for name, row in (('twist', 2), ('accel', 3)):
        for message in messages[name]:
            exact = simulated.platform(stamp_ns(message) * 1e-9)[row]
            np.testing.assert_allclose(content(message), exact, rtol=0, atol=1e-9)
            assert message.header.frame_id == 'base'


def test_pose_is_that_of_the_exact_motion(stream):
    messages, *_ = stream
    for message in messages['pose']:
        R, p, *_ = simulated.platform(stamp_ns(message) * 1e-9)
        at, q = message.pose.position, message.pose.orientation
        np.testing.assert_allclose([at.x, at.y, at.z], p, atol=1e-9)
        axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        np.testing.assert_allclose(4 * q.w * np.array([q.x, q.y, q.z]), axis, atol=1e-9)


def test_passive_joints_close_the_loops(stream):
    """With them each limb, as an open chain, has the platform where it is, moving as it does."""
    messages, *_ = stream
    stewart = models.load(STEWART)
    for joints in messages['passive_joint_states'][::100]:
        t = stamp_ns(joints) * 1e-9
        R, p, twist, _ = simulated.platform(t)
        length, rate, _ = simulated.legs(t)
        position = dict(zip(joints.name, joints.position)) | dict(zip(simulated.LEGS, length))
        velocity = dict(zip(joints.name, joints.velocity)) | dict(zip(simulated.LEGS, rate))
        assert tuple(joints.name) == stewart.passive_joint_names
        for limb in stewart.limbs:
            state = limb.state([position[n] for n in limb.joint_names],
                               [velocity[n] for n in limb.joint_names])
            np.testing.assert_allclose(state.pose[:3, :3], R, atol=1e-9)
            np.testing.assert_allclose(state.pose[:3, 3], p, atol=1e-9)
            np.testing.assert_allclose(state.velocity, twist, atol=1e-9)


def test_diagnostics_tell_the_distance_to_singularities(stream):
    _, report, _ = stream
    level, _, values = report['good']
    assert level == b'\1'
    assert 0.1 < float(values['distance to direct singularity']) < 1
    assert int(values['Newton steps']) < 10


def test_unreachable_samples_are_refused_and_reported(stream):
    _, report, _ = stream
    level, message, values = report['bad']
    assert level == b'\2' and message.startswith('every message is refused')
    assert "loop of limb 'limb_" in message and 'does not close' in message
    assert int(values['refused no_state_at_this_posture']) > 0


def test_serial_robots_have_no_passive_joints():
    class Settings:
        name, outputs = 'arm', ('twist', 'passive_joint_states')

    with pytest.raises(ParameterError, match="'arm.outputs'.*for parallel robots only"):
        check_outputs(Settings, models.load(RPR))

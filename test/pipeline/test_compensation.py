# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A wrench without the weight and the inertia of the load, at the instant of the motion."""
import numpy as np
import pytest

pytest.importorskip('mujoco')

from screw_kinematics import Joint, models, SerialChain    # noqa: E402
from screw_kinematics.errors import ParameterError, Reason    # noqa: E402
from screw_kinematics.messages.joint_state import JointSample    # noqa: E402
from screw_kinematics.messages.wrench import read_wrench, WrenchSample    # noqa: E402
from screw_kinematics.pipeline.compensation import Compensation, WrenchWriter    # noqa: E402
from screw_kinematics.pipeline.group_motion import Motion    # noqa: E402
from screw_kinematics.pipeline.kinematics import Kinematics, State    # noqa: E402
from screw_kinematics.pipeline.parameter_file import robot_settings    # noqa: E402
from screw_kinematics.pipeline.payload import felt_wrench, Payload    # noqa: E402
from screw_kinematics.pipeline.robot_model import build_model    # noqa: E402
from screw_kinematics.pipeline.robot_pipeline import RobotPipeline    # noqa: E402
from screw_kinematics.pipeline.robot_program import compile_robot    # noqa: E402
from screw_kinematics.pipeline.wrench_sensor import WrenchSensor    # noqa: E402
from screw_kinematics.programs.moving_base import MovingBaseProgram    # noqa: E402
from screw_kinematics.screws.rigid import row_of_pose    # noqa: E402
from support import loaded_arm as arm    # noqa: E402

START = 1_700_000_000_000_000_000
LOAD = {'payload.mass': arm.BODY.mass, 'payload.center': list(arm.BODY.center),
        'payload.inertia': list(arm.BODY.inertia)}
GIVEN = {'description': arm.urdf(), 'tip_frame': 'tool0', 'outputs': ['compensated_wrench'],
         'wrench_topic': 'wrench', 'wrench_bias': arm.BIAS.tolist(), **LOAD}


class Rig:
    """A pipeline, a force sensor, and what brings them together."""

    def __init__(self, **values):
        self.settings = robot_settings('arm', {
            **GIVEN, **{key.replace('__', '.'): value for key, value in values.items()}})
        model = build_model(self.settings)
        program = compile_robot(model, (('pose', 'twist', 'accel'),), self.settings)
        self.pipeline = RobotPipeline(model.joint_names, self.settings.motion)
        self.pipeline.activate(Kinematics(program))
        self.sensor = WrenchSensor(self.settings)
        self.sensor.mount(model)
        self.compensation = Compensation(
            WrenchWriter(program.tips[0], self.settings, self.sensor), self.sensor,
            self.settings.stale_timeout)
        self.messages = []

    def joints(self, stamp, q, qd=()):
        state = self.pipeline.take(JointSample(
            stamp, tuple(arm.NAMES), tuple(q.tolist()), tuple(np.asarray(qd).tolist())))
        if not isinstance(state, Reason) and state.order >= 2:
            self.messages += map(read_wrench, self.compensation.take_state(state))
        return state

    def wrench(self, stamp, values, frame=arm.FRAME):
        self.messages += map(read_wrench, self.compensation.take_wrench(
            WrenchSample(stamp, frame, tuple(map(float, values)))))


def play(rig, seconds=4.0, exact=False, late=0.0):
    """Give joint states of 500 Hz and wrenches of 400 Hz, which come so much later [s]."""
    t = np.arange(0, seconds, 0.002)
    q, qd = arm.motion(t)[:2] if exact else arm.readings(t)
    at = np.arange(0.0007, seconds, 0.0025)
    shown = arm.wrenches(at, rng=None if exact else np.random.default_rng(1))
    events = [(x, rig.joints, x, q[k], qd[k]) for k, x in enumerate(t)]
    events += [(x + late, rig.wrench, x, shown[k]) for k, x in enumerate(at)]
    for _, take, stamp, *values in sorted(events, key=lambda event: event[0]):
        take(START + round(stamp * 1e9), *values)
    return rig


def residual(rig):
    """Return stamps since the start [s], and the RMS of forces and of torques once settled."""
    stamps = np.array([m.stamp_ns - START for m in rig.messages]) * 1e-9
    values = np.array([m.values for m in rig.messages])[stamps > 0.5]
    rms = np.sqrt((values**2).sum(axis=0) / len(values))
    return stamps, np.linalg.norm(rms[:3]), np.linalg.norm(rms[3:])


@pytest.mark.parametrize('delay', [0.0, 0.02, 0.05])
def test_a_tenth_is_left_of_what_gravity_compensation_leaves(delay):
    """Encoders quantised, velocities lagging, sensor noise, no contact."""
    stamps, force, torque = residual(play(Rig(estimator__delay=delay)))
    gravity_only = arm.wrenches(np.arange(0.5, 4, 0.01)) - arm.BIAS
    chain = models.load_urdf(arm.urdf(), tip_frame=arm.FRAME)
    R = chain.pose(arm.motion(np.arange(0.5, 4, 0.01))[0])[:, :3, :3]
    weight = np.array(felt_wrench(arm.BODY.parameters, np.einsum('nji,j->in', R, [0, 0, 9.80665]),
                                  np.zeros(3), np.zeros(3))).T
    left = np.sqrt(((gravity_only - weight)**2).mean(axis=0))
    share = force / np.linalg.norm(left[:3]), torque / np.linalg.norm(left[3:])
    assert max(share) < 0.1, share
    # A message for each joint state, stamped with the instant it describes.
    assert set(np.round(np.diff(stamps), 9)) == {0.002}
    assert stamps[-1] == pytest.approx(3.998 - delay, abs=0.003)


@pytest.mark.parametrize('values', [
    {}, {'expressed_in': 'tip'}, {'reference_point': 'base'},
    {'tool_offset': [0.1, 0.2, 0.3, 0.1, 0.2, 0.3]}, {'wrench_frame': arm.FRAME}])
def test_axes_and_points_of_other_outputs_do_not_matter(values):
    rig = play(Rig(velocity_source='measured', **values), 1.0, exact=True)
    _, force, torque = residual(rig)
    assert len(rig.messages) > 400 and {m.frame_id for m in rig.messages} == {arm.FRAME}
    assert force < 0.05 and torque < 0.005, (force, torque)


@pytest.mark.parametrize('pole', ['tip', 'base'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_a_base_that_moves_is_felt_too(axes, pole):
    """A vehicle's joints and the arm's as one chain that stands still feel the same."""
    vehicle = [Joint('x', 'prismatic', axis=(1, 0, 0)), Joint('y', 'prismatic', axis=(0, 1, 0)),
               Joint('tilt', 'revolute', axis=(0.6, 0, 0.8))]
    seat = SerialChain(vehicle, base_frame='odom')
    chain = models.load_urdf(arm.urdf(), tip_frame='tool0')
    one = SerialChain([*vehicle, *chain.joints], chain.T_base_tool, 'odom', 'tool0',
                      fixed_frames=chain.fixed_frames)
    motion = np.random.default_rng(3).normal(size=(3, 9))
    needs = ('pose', 'twist', 'accel')
    moved = MovingBaseProgram(chain, needs, axes, pole)
    state = seat.state(*motion[:, :3], *np.zeros((2, 3)))
    base = [*row_of_pose(state.pose), *np.ravel(state.body_derivatives())]
    alone = one.compile(needs, axes, pole)
    settings = robot_settings('arm', {**GIVEN, 'expressed_in': axes, 'reference_point': pole,
                                      'base_motion_topic': 'odom'})
    found = []
    for program, inputs in ((moved, [*motion[:, 3:].ravel(), *base]),
                            (alone, motion.ravel().tolist())):
        sensor = WrenchSensor(settings)
        sensor.mount(one)
        sensor.take(WrenchSample(START, arm.FRAME, (1.0, 2.0, 3.0, 0.1, 0.2, 0.3)))
        writer = WrenchWriter(program.slices, settings, sensor)
        values = program.evaluate(inputs)
        found.append(read_wrench(writer.encode(State(START, values, Motion(START, []), 2))).values)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9, atol=1e-9)
    still = alone.evaluate([*motion[0], *np.zeros(18)])
    resting = read_wrench(writer.encode(State(START, still, Motion(START, []), 2))).values
    assert np.abs(np.subtract(resting, found[1])).max() > 1


def test_contact_is_what_is_left_whoever_exerts_the_measured_wrench():
    for by, sign in (('load', 1.0), ('sensor', -1.0)):
        rig = Rig(velocity_source='measured', wrench_by=by, wrench_bias=[0.0] * 6)
        t = np.arange(0, 1, 0.002)
        contact = np.array([3.0, -1.0, 5.0, 0.1, 0.2, -0.4])
        shown = sign * (arm.wrenches(t) - arm.BIAS) + contact
        for k, (q, qd) in enumerate(zip(*arm.motion(t)[:2])):
            rig.joints(START + round(t[k] * 1e9), q, qd)
            rig.wrench(START + round(t[k] * 1e9), shown[k])
        found = np.array([m.values for m in rig.messages[200:]])
        np.testing.assert_allclose(found, np.tile(contact, (len(found), 1)), atol=0.05)


def test_whichever_comes_first_waits_for_the_other():
    early, late = play(Rig(), 1.0), play(Rig(), 1.0, late=0.1)
    common = {m.stamp_ns: m.values for m in early.messages}
    assert len(late.messages) > 400
    for message in late.messages:
        np.testing.assert_allclose(message.values, common[message.stamp_ns], atol=1e-9)
    assert not late.sensor.left_out


def test_a_hole_in_the_wrenches_is_a_hole_in_the_output():
    rig = Rig(velocity_source='measured', stale_timeout=0.5)
    t = np.arange(0, 2, 0.002)
    shown = arm.wrenches(t)
    for k, (q, qd) in enumerate(zip(*arm.motion(t)[:2])):
        stamp = START + round(t[k] * 1e9)
        rig.joints(stamp, q, qd)
        if not 0.5 < t[k] < 1.2:
            rig.wrench(stamp, shown[k])
    stamps = np.array([m.stamp_ns - START for m in rig.messages]) * 1e-9
    assert not ((stamps > 0.5001) & (stamps < 1.1999)).any() and stamps[-1] > 1.99
    assert rig.sensor.left_out[Reason.NOT_COVERED] == pytest.approx(350, abs=3)
    assert rig.sensor.compensated == len(rig.messages)


def test_messages_of_no_use_are_refused_and_counted():
    rig = Rig(velocity_source='measured')
    q = arm.motion([0.0])[0][0]
    for stamp, values, frame in ((1, [1.0] * 6, 'hand'), (2, [np.nan] * 6, arm.FRAME),
                                 (3, [1.0] * 6, arm.FRAME), (3, [1.0] * 6, arm.FRAME),
                                 (4, [1.0] * 6, 'tool0'), (-5, [1.0] * 6, arm.FRAME),
                                 (6, [1e308] * 6, arm.FRAME)):
        rig.wrench(stamp, values, frame)
    assert rig.sensor.account.refused == {
        Reason.UNKNOWN_FRAME: 2, Reason.VALUES_NOT_FINITE: 2, Reason.STAMP_NOT_INCREASING: 1,
        Reason.STAMP_NEGATIVE: 1}
    assert "'tool0'" in rig.sensor.account.details[Reason.UNKNOWN_FRAME]
    assert rig.sensor.account.used == 1 and not rig.messages
    assert isinstance(rig.joints(START, q), Reason)


def test_frames_have_the_prefix_of_the_robot():
    rig = Rig(frame_prefix='left/', wrench_frame='tool0')
    rig.wrench(1, [1.0] * 6, 'anything')
    assert rig.sensor.frame_id == 'left/tool0' and rig.sensor.account.used == 1
    rig = Rig(frame_prefix='left/')
    rig.wrench(1, [1.0] * 6, f'left/{arm.FRAME}')
    assert rig.sensor.frame_id == f'left/{arm.FRAME}'


@pytest.mark.parametrize('values, message', [
    ({'payload.mass': -1.0}, "'arm.payload.mass' is -1.0; allowed: a number from 0"),
    ({'payload.inertia': [1.0, 0.0, 0.0, 1.0, 0.0, 3.0]}, 'larger than the two others'),
    ({'payload.inertia': [1.0, 2.0, 0.0, 1.0, 0.0, 1.0]}, 'no principal moment is negative'),
    ({'payload.center': [0.0, np.nan, 0.0]}, "'arm.payload.center'.*three finite numbers"),
    ({'wrench_bias': [0.0] * 3}, "'arm.wrench_bias'.*six finite numbers"),
    ({'wrench_topic': ''}, "'arm.wrench_topic' is ''; allowed: the topic of a force sensor"),
    ({'wrench_frame': 'elbow_link'}, "'elbow_link'; allowed: a link that is fixed to the tip "
     "frame 'tool0': .*ft_frame"),
    ({'wrench_by': 'nobody'}, "'arm.wrench_by' is 'nobody'; allowed: one of load, sensor")])
def test_wrong_parameters_are_named(values, message):
    with pytest.raises(ParameterError, match=message):
        build_model(robot_settings('arm', {**GIVEN, **values}))


def test_inertial_parameters_are_those_of_the_body():
    again = Payload.of(arm.BODY.parameters)
    assert again.mass == arm.BODY.mass
    np.testing.assert_allclose([*again.center, *again.inertia],
                               [*arm.BODY.center, *arm.BODY.inertia], atol=1e-15)

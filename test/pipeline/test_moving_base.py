# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A robot on a moving base: composition, the base's estimated motion, what is refused."""
import math

import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ParameterError, Reason
from screw_kinematics.messages.base_motion import BaseSample
from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.pipeline.kinematics import Kinematics
from screw_kinematics.pipeline.moving_base import BaseFrames, MovingBase
from screw_kinematics.pipeline.parameter_file import robot_settings
from screw_kinematics.pipeline.robot_model import build_model
from screw_kinematics.pipeline.robot_pipeline import RobotPipeline
from screw_kinematics.pipeline.robot_program import compile_robot
from screw_kinematics.pipeline.settings import MotionSettings
from screw_kinematics.programs.moving_base import AT_REST, BASE_INPUTS, carry, MovingBaseProgram
from screw_kinematics.screws.exponential import exp
from screw_kinematics.screws.rigid import row_of_pose
from screw_kinematics.screws.rotations import pose, quaternion_from_rotation, rotation_about
from screw_kinematics.screws.se3 import inverse

PANDA = 'package://screw_kinematics/config/robots/panda.yaml'
STATES = ('pose', 'twist', 'accel', 'jerk', 'snap', 'reduced_accel', 'reduced_jerk')


class Bend:
    """
    An exact motion of a base: a constant twist about a fixed screw, times a function of time.

    Its components in the body are those in space turned back, so the whole motion is known.
    """

    def __init__(self, seed=0):
        rng = np.random.default_rng(seed)
        self.start = exp(rng.normal(size=6))
        self.screw = rng.normal(size=6)     # in axes of the body, fixed in it

    def phase(self, t):
        """Return the way along the screw and its derivatives, up to the fourth."""
        w = 0.9
        return 0.4 * np.array([math.sin(w * t + k * math.pi / 2) * w**k for k in range(5)])

    def pose(self, t):
        return self.start @ exp(self.screw * self.phase(t)[0])

    def components(self, t):
        """Return the twist in the body's axes and its derivatives, shape (4, 6)."""
        return np.outer(self.phase(t)[1:], self.screw)

    def sample(self, t, frame='base', world='odom'):
        place = self.pose(t)
        return BaseSample(round(t * 1e9), frame, tuple(self.components(t)[0]), world,
                          tuple(place[:3, 3]), tuple(quaternion_from_rotation(place[:3, :3])))


def numbers_of(place, components):
    return [*row_of_pose(place), *np.ravel(components)]


@pytest.mark.parametrize('pole', ['tip', 'base'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_states_are_those_of_one_chain_with_the_base_as_its_first_joints(axes, pole):
    """A planar vehicle's three joints and the arm's as one chain, to the fourth derivative."""
    from screw_kinematics import Joint, SerialChain
    rng = np.random.default_rng(1)
    vehicle = SerialChain([Joint('x', 'prismatic', axis=(1, 0, 0)),
                           Joint('y', 'prismatic', axis=(0, 1, 0)),
                           Joint('yaw', 'revolute', axis=(0, 0, 1))], base_frame='odom')
    arm = models.load(PANDA)
    one = SerialChain([*vehicle.joints, *arm.joints], arm.T_base_tool, 'odom', 'tool')
    motion = rng.normal(size=(5, 10))
    seat = vehicle.state(*motion[:, :3])
    program = MovingBaseProgram(arm, STATES, axes, pole)
    found = program.evaluate([*motion[:, 3:].ravel(),
                              *numbers_of(seat.pose, seat.body_derivatives())])
    expected = one.compile(STATES, axes, pole).evaluate(motion.ravel().tolist())
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-10)
    batch = program.batch(*(motion[:, None, 3:]), base=np.array(
        [numbers_of(seat.pose, seat.body_derivatives())]))
    for name, part in program.slices.items():
        np.testing.assert_allclose(batch[name][0], found[part], rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize('pole', ['tip', 'base'])
@pytest.mark.parametrize('axes', ['base', 'tip'])
def test_states_agree_with_a_free_flyer_of_pinocchio(axes, pole):
    """Twist and accelerations of a mobile manipulator, to 1e-9 and far below."""
    from support.pinocchio_reference import angular_first, example_robot, pin
    path = example_robot('panda')
    arm = models.load(path, 'panda_link0', 'panda_link8')
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    data, frame = model.createData(), model.getFrameId('panda_link8')
    rng = np.random.default_rng(2)
    program = MovingBaseProgram(arm, ('pose', 'twist', 'accel', 'reduced_accel'), axes, pole)
    for _ in range(20):
        seat = exp(rng.normal(size=6))
        twist, rate = rng.normal(size=(2, 6))
        q, qd, qdd = rng.uniform(-2, 2, size=(3, 7))
        fingers = np.zeros(model.nv - 13)
        quaternion = quaternion_from_rotation(seat[:3, :3])
        linear_first = [3, 4, 5, 0, 1, 2]
        # Pinocchio's acceleration of the free flyer is the derivative of its components.
        pin.forwardKinematics(
            model, data, np.concatenate([seat[:3, 3], quaternion, q, fingers]),
            np.concatenate([twist[linear_first], qd, fingers]),
            np.concatenate([rate[linear_first], qdd, fingers]))
        pin.updateFramePlacements(model, data)
        found = program.evaluate([*q, *qd, *qdd, *numbers_of(seat, [twist, rate, *[[0] * 6] * 2])])
        place = data.oMf[frame]
        np.testing.assert_allclose(found[:3], place.translation, atol=1e-12)
        np.testing.assert_allclose(found[3:12], place.rotation.ravel(), atol=1e-12)
        as_world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED if pole == 'tip' else (
            pin.ReferenceFrame.WORLD)
        velocity = angular_first(pin.getFrameVelocity(model, data, frame, as_world))
        spatial = angular_first(pin.getFrameAcceleration(model, data, frame, as_world))
        classical = spatial.copy()
        classical[3:] += np.cross(velocity[:3], velocity[3:])
        turn = place.rotation.T if axes == 'tip' else np.eye(3)
        for name, known in (('twist', velocity), ('accel', classical),
                            ('reduced_accel', spatial)):
            known = np.concatenate([turn @ known[:3], turn @ known[3:]])
            np.testing.assert_allclose(found[program.slices[name]], known, rtol=0,
                                       atol=1e-12 * max(1, np.abs(known).max()))


def test_the_jacobian_has_the_base_behind_the_joints():
    rng = np.random.default_rng(3)
    arm = models.load(PANDA)
    for axes in ('base', 'tip'):
        for pole in ('base', 'tip'):
            program = MovingBaseProgram(arm, ('twist', 'jacobian'), axes, pole)
            q, qd, u = rng.normal(size=7), rng.normal(size=7), rng.normal(size=6)
            values = program.evaluate([*q, *qd, *numbers_of(
                exp(rng.normal(size=6)), [u, *[[0] * 6] * 3])])
            jacobian = np.reshape(values[program.slices['jacobian']], (6, 13))
            np.testing.assert_allclose(jacobian @ [*qd, *u], values[program.slices['twist']],
                                       atol=1e-13)


def test_a_parallel_robot_moves_with_its_base_too():
    platform = models.load('package://screw_kinematics/config/robots/planar_3rrr.yaml')
    rng = np.random.default_rng(4)
    outputs = ('pose', 'twist', 'accel', 'passive_velocity')
    program, plain = MovingBaseProgram(platform, outputs), platform.compile(outputs)
    values = [*platform.home.actuated, *rng.normal(size=2 * platform.dof)]
    np.testing.assert_allclose(program.evaluate([*values, *AT_REST]), plain.evaluate(values),
                               atol=1e-12)


def test_a_motion_is_carried_by_its_derivatives():
    """The exact motion is met up to the first term that is left out."""
    bend = Bend()
    for dt, tolerance in ((0.01, 1e-9), (0.02, 2e-8), (0.1, 2e-5), (-0.05, 1e-6)):
        t = 0.7
        carried = carry([*numbers_of(bend.pose(t - 2 * dt), bend.components(t)), 3 * dt, dt])
        assert len(carried) == BASE_INPUTS
        np.testing.assert_allclose(carried[:12], row_of_pose(bend.pose(t + dt)), rtol=0,
                                   atol=100 * tolerance)
        np.testing.assert_allclose(carried[12:18], bend.components(t + dt)[0], rtol=0,
                                   atol=tolerance)


def moving_base(settings=None, frames=None, **more):
    return MovingBase(frames or BaseFrames('base', {'base': np.eye(4)}),
                      settings or MotionSettings(), **more)


@pytest.mark.parametrize('delay, share', [(0.0, 0.08), (0.05, 0.03)])
def test_accelerations_are_estimated_from_the_twist(delay, share):
    """Of noisy odometry at 50 Hz, at the instants of joints at 500 Hz."""
    rng, bend = np.random.default_rng(5), Bend()
    base = moving_base(MotionSettings(delay=delay))
    errors, signals, doubts = [], [], []
    for k in range(5000):
        t = 1000 + k * 0.002
        if k % 10 == 0:
            sample = bend.sample(t)
            noisy = np.array(sample.twist) + 1e-4 * rng.normal(size=6)
            base.take(sample._replace(twist=tuple(noisy)))
        known = base.at(round((t - delay) * 1e9))
        if k > 1000:
            errors.append(np.array(known.values[18:24]) - bend.components(t - delay)[1])
            signals.append(bend.components(t - delay)[1])
            np.testing.assert_allclose(known.values[:12], row_of_pose(bend.pose(t - delay)),
                                       atol=1e-4)
            doubts.append(np.array(known.variances(2)))
    rms = [float(np.sqrt(np.mean(np.square(x)))) for x in (errors, signals)]
    assert rms[0] < share * rms[1], rms
    # What it says of its own error is right to a factor.
    assert 0.3 < np.sqrt(np.mean(doubts)) / rms[0] < 3
    assert base.faults() == base.doubts() == []


def test_a_twist_alone_leaves_the_axes_of_the_base():
    bend, base = Bend(), moving_base()
    for k in range(20):
        sample = bend.sample(k * 0.02)._replace(world=None)
        base.take(BaseSample(sample.stamp_ns + 1, sample.frame, sample.twist))
    known = base.at(19 * 20_000_000 + 1)
    assert known.values[:12] == AT_REST[:12] and base.world == 'base'
    np.testing.assert_allclose(known.values[12:18], bend.components(0.38)[0], atol=1e-3)


def test_frames_fixed_to_the_base_serve_too():
    """The same motion, measured of a frame beside the base and under it."""
    bend = Bend()
    mount = pose(rotation_about(np.array([0.6, 0.0, 0.8]), 0.7), (0.3, -0.2, 0.5))
    frames = BaseFrames('arm', {'arm': np.eye(4), 'wheels': inverse(mount)}, 'r1/')
    base = moving_base(frames=frames)
    for k in range(30):
        base.take(bend.sample(1 + k * 0.01, 'r1/wheels'))
    known = base.at(round(1.29e9))
    np.testing.assert_allclose(known.values[:12], row_of_pose(bend.pose(1.29) @ mount),
                               atol=1e-9)
    u, r = bend.components(1.29)[0], mount[:3, 3]
    expected = [*mount[:3, :3].T @ u[:3], *mount[:3, :3].T @ (u[3:] + np.cross(u[:3], r))]
    np.testing.assert_allclose(known.values[12:18], expected, atol=1e-3)


@pytest.mark.parametrize('change, reason, words', [
    ({'twist': (0.0, 0.0, math.nan, 0.0, 0.0, 0.0)}, Reason.VALUES_NOT_FINITE, 'nan'),
    ({'position': (math.inf, 0.0, 0.0)}, Reason.VALUES_NOT_FINITE, 'inf'),
    ({'quaternion': (0.0, 0.0, 0.0, 0.0)}, Reason.BASE_ORIENTATION, 'length 0; allowed: 1'),
    ({'quaternion': (0.0, 0.0, 0.0, 1.1)}, Reason.BASE_ORIENTATION, 'length 1.1'),
    ({'frame': 'base_footprint'}, Reason.BASE_FRAME, "'base_footprint'; allowed: 'base'"),
    ({'world': ''}, Reason.BASE_FRAME, "frame_id is ''"),
    ({'world': 'map'}, Reason.BASE_FRAME, "frame_id is 'map'; allowed: 'odom'"),
    ({'stamp_ns': 10**9}, Reason.STAMP_NOT_INCREASING, 'at 1.000 s'),
    ({'twist': (0.0, 0.0, 90.0, 0.0, 0.0, 0.0)}, Reason.IMPLAUSIBLE_JUMP, '')])
def test_wrong_messages_are_refused_and_the_rest_goes_on(change, reason, words):
    bend, base = Bend(), moving_base()
    for k in range(20):
        base.take(bend.sample(1 + k * 0.01))
    assert base.take(bend.sample(1.2)._replace(**change)) is reason
    assert words in base.account.details[reason] and words in base.problem()
    motion = base.take(bend.sample(1.21))
    np.testing.assert_allclose(motion.values[12:18], bend.components(1.21)[0], atol=1e-3)
    assert base.account.refused == {reason: 1}
    assert base.account.received == 22


def test_a_motion_that_is_missing_or_too_old_is_told():
    bend, base = Bend(), moving_base(timeout=0.2)
    assert base.at(10**9) is Reason.BASE_MISSING
    assert base.problem() == 'no message of the base came'
    base.take(bend.sample(1.0))
    assert base.at(10**9) is Reason.SETTLING
    for k in range(20):
        base.take(bend.sample(1.01 + k * 0.01))
    assert not isinstance(base.at(round(1.35e9)), Reason)
    assert base.at(round(1.45e9)) is Reason.BASE_TOO_OLD
    assert base.problem() == '21 messages of the base came'
    base.reset()
    assert base.at(round(1.2e9)) is Reason.BASE_MISSING


def test_another_world_is_followed_when_the_old_one_is_silent():
    bend, base = Bend(), moving_base(timeout=0.2)
    for k in range(20):
        base.take(bend.sample(1 + k * 0.01))
    for k in range(20):
        base.take(bend.sample(1.5 + k * 0.01, world='map'))
    assert base.world == 'map'
    assert base.at(round(1.69e9)).values[0] == pytest.approx(bend.pose(1.69)[0, 3])


@pytest.mark.parametrize('fault, words', [
    (lambda place, u: place[:3, :3] @ u, 'axes of the world'),
    (lambda place, u: 0 * u, 'does not tell how its pose moves')])
def test_twists_that_contradict_the_poses_are_named(fault, words):
    """As drivers have them: in axes of the odometry's frame, or never set."""
    base = moving_base()
    start = pose(rotation_about(np.array([0.0, 0.0, 1.0]), 1.2))
    screw = np.array([0.0, 0.0, 0.3, 1.0, 0.0, 0.0])
    for k in range(300):
        place = start @ exp(0.02 * k * screw)
        linear = fault(place, screw[3:])
        base.take(BaseSample(10**9 + 20_000_000 * k, 'base', (0, 0, 0.3, *linear), 'odom',
                             tuple(place[:3, 3]), tuple(quaternion_from_rotation(place[:3, :3]))))
    fault, = base.faults()
    assert words in fault


def pipeline_of(parameters):
    """Return a pipeline as the node has it, and its settings."""
    settings = robot_settings('arm', {'description': PANDA, **parameters})
    model = build_model(settings)
    pipeline = RobotPipeline(model.joint_names, settings.motion)
    pipeline.base = MovingBase(BaseFrames.of(model, settings.frame_prefix), settings.motion)
    needs = tuple(('twist',) for _ in settings.parts)
    pipeline.activate(Kinematics(compile_robot(model, needs, settings)))
    return pipeline, model, settings


def joint_sample(model, t):
    n = len(model.joint_names)
    return JointSample(round(t * 1e9), model.joint_names, (0.1 * math.sin(t),) * n,
                       (0.1 * math.cos(t),) * n)


def test_without_the_base_what_is_relative_to_it_goes_on():
    pipeline, model, settings = pipeline_of({
        'base_motion_topic': 'odom', 'velocity_source': 'measured',
        'tips': ['panda_link8'], 'panda_link8.relative_to': 'base'})
    state = pipeline.take(joint_sample(model, 1.0))
    assert not state.without_base
    pipeline, model, settings = pipeline_of({
        'base_motion_topic': 'odom', 'velocity_source': 'measured'})
    assert pipeline.take(joint_sample(model, 1.0)) is Reason.BASE_MISSING
    assert pipeline.account.details[Reason.BASE_MISSING] == 'no message of the base came'
    bend = Bend()
    for k in range(20):
        pipeline.base.take(bend.sample(2 + k * 0.01, 'panda_link0'))
    state = pipeline.take(joint_sample(model, 2.193))
    arm = model.state([0.1 * math.sin(2.193)] * 7, [0.1 * math.cos(2.193)] * 7)
    u = bend.components(2.193)[0]
    expected = bend.pose(2.193)[:3, :3] @ (
        u[3:] + np.cross(u[:3], arm.pose[:3, 3]) + arm.velocity[3:])
    np.testing.assert_allclose(state.values[3:6], expected, atol=1e-2)
    assert pipeline.take(joint_sample(model, 3.0)) is Reason.BASE_TOO_OLD


TWO_ARMS = '<robot name="two"><link name="base"/>' + ''.join(
    f'<link name="{name}"/><joint name="q_{name}" type="revolute"><parent link="base"/>'
    f'<child link="{name}"/><origin xyz="0 {y} 0.3" rpy="{y} 0 0"/><axis xyz="0 0 1"/>'
    '<limit lower="-9" upper="9" effort="1" velocity="9"/></joint>'
    for name, y in (('left', 0.2), ('right', -0.2), ('head', 0.0))) + '</robot>'


@pytest.mark.parametrize('needs', [
    (('twist', 'accel'), ('twist',), ('pose',)), (('pose',), (), ('jerk',)),
    ((), ('twist',), ()), (('twist',), (), ())])
def test_tips_relative_to_base_and_world_side_by_side(needs):
    """Each is what a robot of its own would be."""
    settings = robot_settings('two', {
        'description': TWO_ARMS, 'tips': ['left', 'right', 'head'], 'base_motion_topic': 'odom',
        'right.relative_to': 'base'})
    model = build_model(settings)
    program = compile_robot(model, needs, settings)
    assert program.moving_base == bool(needs[0] or needs[2])
    assert program.standing_base == bool(needs[1])
    rng = np.random.default_rng(6)
    motion, base = rng.normal(size=(program.order + 1, 3)), [
        *row_of_pose(exp(rng.normal(size=6))), *rng.normal(size=24)]
    values = program.evaluate([*motion.ravel(), *(base if program.moving_base else ())])
    for tip, own, wanted, slices in zip(model.tips, settings.parts, needs, program.tips):
        assert set(slices) == set(wanted)
        if wanted:
            alone = compile_robot(tip, (wanted,), own)
            column = model.joint_names.index(tip.joint_names[0])
            expected = alone.evaluate([*motion[:alone.order + 1, column],
                                       *(base if alone.moving_base else ())])
            for name, part in alone.tips[0].items():
                np.testing.assert_array_equal(values[slices[name]], expected[part])


def test_relative_to_needs_to_know_how_the_base_moves():
    with pytest.raises(ParameterError, match="'arm.relative_to' is 'world'.*base_motion_topic"):
        robot_settings('arm', {'relative_to': 'world'})
    with pytest.raises(ParameterError, match="'arm.b.relative_to' is 'world'"):
        robot_settings('arm', {'tips': ['a', 'b'], 'b.relative_to': 'world'})
    with pytest.raises(ParameterError, match='allowed: base, world, or nothing'):
        robot_settings('arm', {'relative_to': 'odom'})
    assert robot_settings('arm', {}).relative_to == 'base'
    settings = robot_settings('arm', {'base_motion_topic': 'odom', 'tips': ['a', 'b'],
                                      'b.relative_to': 'base'})
    assert [part.relative_to for part in settings.parts] == ['world', 'base']
    assert settings.on_moving_base

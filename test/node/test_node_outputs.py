# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""All outputs of a running node against the chain, and against each other."""
from geometry_msgs.msg import (
    AccelStamped, AccelWithCovarianceStamped, PoseStamped, TwistStamped,
    TwistWithCovarianceStamped, VelocityStamped)
import numpy as np
import pytest
from screw_kinematics import models
from screw_kinematics.errors import Reason
from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.pipeline.kinematics import Kinematics
from screw_kinematics.pipeline.robot_pipeline import RobotPipeline
from screw_kinematics.pipeline.robot_program import OneTip
from screw_kinematics.pipeline.settings import MotionSettings
from screw_kinematics.screws.rotations import pose, rotation_from_quaternion, rotation_rpy
from screw_kinematics.screws.se3 import rotate, shift_pole
from support.rig import joint_state, PUMA, running, six, smooth_motion, stamp_ns
from visualization_msgs.msg import Marker, MarkerArray

TYPES = {
    'pose': PoseStamped, 'twist': TwistStamped, 'accel': AccelStamped,
    'reduced_accel': AccelStamped, 'jerk': AccelStamped, 'snap': AccelStamped,
    'velocity': VelocityStamped, 'twist_with_covariance': TwistWithCovarianceStamped,
    'accel_with_covariance': AccelWithCovarianceStamped}
OFFSET = [0.1, -0.05, 0.2, 0.3, -0.4, 0.5]
PERIOD = 5_000_000
START = 100_000_000_000
SAMPLES = 120
AT_REST = [0.2] * 6, [0.0] * 6
JOINTS = [f'q{i}' for i in range(1, 7)]
ROBOTS = {
    'plain': {'outputs': [*TYPES, 'markers'], 'markers_rate': 50.0},
    'turned': {'outputs': ['twist', 'accel'], 'expressed_in': 'tip', 'frame_prefix': 'left/'},
    'rooted': {'outputs': ['twist', 'accel', 'reduced_accel'], 'reference_point': 'base'},
    'tooled': {'outputs': ['pose', 'twist', 'accel'], 'tool_offset': OFFSET},
    'measured': {'outputs': ['twist', 'accel', 'twist_with_covariance'],
                 'velocity_source': 'measured'},
    'quick': {'outputs': ['twist'], 'velocity_source': 'measured'},
    'delayed': {'outputs': ['pose', 'accel'], 'estimator': {'delay': 0.02}}}


@pytest.fixture(scope='module')
def outputs(module_context, tmp_path_factory):
    """Run a node with all these robots over one motion; return messages by robot and output."""
    parameters = {'robots': list(ROBOTS)} | {
        name: {'description': PUMA, **settings} for name, settings in ROBOTS.items()}
    with running(module_context, tmp_path_factory.mktemp('outputs'), parameters) as rig:
        messages = {(name, output): rig.listen(
            f'{name}/{output}', TYPES.get(output, MarkerArray))
            for name, settings in ROBOTS.items() for output in settings['outputs']}
        publisher = rig.publisher('joint_states')
        for name, settings in ROBOTS.items():
            order = [*TYPES, 'markers']
            rig.wait_until_serving(name, sorted(settings['outputs'], key=order.index))
        # Programs are made in the background: send what they do not see, until all answer.
        warm_up, sent = 1_000_000_000, 0
        while not all(messages.values()):
            # At rest, which tells nothing of the encoders for a new run to remember.
            publisher.publish(joint_state(JOINTS, warm_up, *AT_REST))
            rig.spin(0.004)
            sent += 1
            warm_up += PERIOD if sent % 10 else 300_000_000
        for k in range(SAMPLES):
            q, qd = smooth_motion(6, k * PERIOD * 1e-9)
            publisher.publish(joint_state(JOINTS, START + k * PERIOD, q, qd))
            rig.spin(0.003)
        last = START + (SAMPLES - 1) * PERIOD
        rig.wait(lambda: all(
            stamp_ns(m[-1]) >= last - 20_000_000 for (_, output), m in messages.items()
            if output != 'markers'))
        yield {key: [m for m in of_key if output_stamp(m) >= START]
               for key, of_key in messages.items()}


def output_stamp(message):
    """Return the stamp of a message or of its first marker."""
    return stamp_ns(message.markers[0] if hasattr(message, 'markers') else message)


def content(message):
    """Return the six-vector of a message."""
    for part in ('twist', 'accel', 'velocity'):
        if hasattr(message, part):
            value = getattr(message, part)
            return six(getattr(value, part, value))
    raise TypeError(message)


def by_stamp(messages):
    """Return six-vectors by stamp."""
    return {stamp_ns(m): content(m) for m in messages}


def displacement(message):
    """Return the pose of a message as a matrix."""
    p, o = message.pose.position, message.pose.orientation
    return pose(rotation_from_quaternion(np.array([o.x, o.y, o.z, o.w])), (p.x, p.y, p.z))


def poses(messages):
    """Return displacements by stamp."""
    return {stamp_ns(m): displacement(m) for m in messages}


def offline(settings, outputs, **frames):
    """Return what the logic of the node makes of the same samples."""
    chain = models.load(PUMA)
    program = chain.compile(outputs=outputs, **frames)
    pipeline = RobotPipeline(chain.joint_names, settings)
    pipeline.activate(Kinematics(OneTip(program)))
    results = {}
    for k in range(SAMPLES):
        q, qd = smooth_motion(6, k * PERIOD * 1e-9)
        state = pipeline.take(JointSample(
            START + k * PERIOD, tuple(JOINTS), tuple(q.tolist()), tuple(qd.tolist())))
        if not isinstance(state, Reason):
            results[state.stamp_ns] = {
                name: np.array(state.values[at]) for name, at in program.slices.items()}
    return results


@pytest.mark.parametrize('output', ['twist', 'accel', 'reduced_accel', 'jerk', 'snap'])
def test_each_output_is_what_the_logic_makes_of_the_samples(outputs, output):
    expected = offline(MotionSettings(), (output,))
    got = by_stamp(outputs['plain', output])
    assert list(got) == list(expected)
    for stamp, values in expected.items():
        assert np.allclose(got[stamp], values[output], rtol=1e-9, atol=1e-9), stamp


@pytest.mark.parametrize('robot', ['quick', 'measured'])
def test_measured_twist_is_the_chains(outputs, robot):
    chain = models.load(PUMA)
    twists = by_stamp(outputs[robot, 'twist'])
    assert list(twists) == [START + k * PERIOD for k in range(SAMPLES)]
    for stamp, twist in twists.items():
        state = chain.state(*smooth_motion(6, (stamp - START) * 1e-9))
        assert np.allclose(twist, state.velocity, rtol=1e-12, atol=1e-14)


def test_pose_is_the_chains_and_its_quaternion_has_unit_length(outputs):
    chain = models.load(PUMA)
    for message in outputs['plain', 'pose']:
        q, _ = smooth_motion(6, (stamp_ns(message) - START) * 1e-9)
        assert np.allclose(displacement(message), chain.pose(q), atol=1e-5)
        o = message.pose.orientation
        assert np.isclose(np.linalg.norm([o.x, o.y, o.z, o.w]), 1.0, rtol=1e-12)
        assert message.header.frame_id == 'base'


@pytest.mark.parametrize('output', ['twist', 'accel'])
def test_axes_of_the_tip(outputs, output):
    in_base = by_stamp(outputs['plain', output])
    for message in outputs['turned', output]:
        stamp = stamp_ns(message)
        rotation = poses(outputs['plain', 'pose'])[stamp][:3, :3]
        assert np.allclose(content(message), rotate(rotation.T, in_base[stamp]), atol=1e-9)
        assert message.header.frame_id == 'left/tool'


@pytest.mark.parametrize('output', ['twist', 'reduced_accel'])
def test_reference_point_at_the_base(outputs, output):
    at_tip, places = by_stamp(outputs['plain', output]), poses(outputs['plain', 'pose'])
    for stamp, value in by_stamp(outputs['rooted', output]).items():
        expected = shift_pole(at_tip[stamp], -places[stamp][:3, 3])
        assert np.allclose(value, expected, atol=1e-9)


def test_classical_acceleration_at_the_base_is_of_the_material_point(outputs):
    reduced, twists = (by_stamp(outputs['rooted', o]) for o in ('reduced_accel', 'twist'))
    for stamp, accel in by_stamp(outputs['rooted', 'accel']).items():
        w, v = twists[stamp][:3], twists[stamp][3:]
        assert np.allclose(accel[3:], reduced[stamp][3:] + np.cross(w, v), atol=1e-9)


def test_a_tool_is_mounted_on_the_tip(outputs):
    flange, tool = poses(outputs['plain', 'pose']), poses(outputs['tooled', 'pose'])
    mount = pose(rotation_rpy(*OFFSET[3:]), OFFSET[:3])
    twists = by_stamp(outputs['plain', 'twist'])
    for stamp, twist in by_stamp(outputs['tooled', 'twist']).items():
        assert np.allclose(tool[stamp], flange[stamp] @ mount, atol=1e-9)
        step = tool[stamp][:3, 3] - flange[stamp][:3, 3]
        assert np.allclose(twist, shift_pole(twists[stamp], step), atol=1e-9)


def test_velocity_names_body_and_reference(outputs):
    twists = by_stamp(outputs['plain', 'twist'])
    for message in outputs['plain', 'velocity']:
        assert (message.body_frame_id, message.reference_frame_id) == ('tool', 'base')
        assert message.header.frame_id == 'base'
        assert np.array_equal(content(message), twists[stamp_ns(message)])


def covariance(message):
    """Return the covariance of a message, angular first."""
    part = message.twist if hasattr(message, 'twist') else message.accel
    order = [3, 4, 5, 0, 1, 2]
    return np.array(part.covariance).reshape(6, 6)[np.ix_(order, order)]


@pytest.mark.parametrize('output', ['twist_with_covariance', 'accel_with_covariance'])
def test_covariance_is_positive_and_of_joints_that_err_independently(outputs, output):
    chain = models.load(PUMA)
    values = by_stamp(outputs['plain', output.split('_')[0]])
    for message in outputs['plain', output][20:]:
        stamp = stamp_ns(message)
        assert np.array_equal(content(message), values[stamp])
        matrix = covariance(message)
        assert np.allclose(matrix, matrix.T, rtol=1e-12) and np.all(np.diag(matrix) > 0)
        q, _ = smooth_motion(6, (stamp - START) * 1e-9)
        screws = chain.screws(q).T
        joints = np.linalg.solve(screws, np.linalg.solve(screws, matrix).T)
        off = joints - np.diag(np.diag(joints))
        assert np.abs(off).max() < 1e-2 * np.diag(joints).max()


def test_unknown_covariance_is_zero(outputs):
    messages = outputs['measured', 'twist_with_covariance']
    assert messages and not any(covariance(m).any() for m in messages)


def test_delayed_outputs_are_stamped_with_the_instant_they_describe(outputs):
    chain = models.load(PUMA)
    accels = by_stamp(outputs['delayed', 'accel'])
    newest = START + (SAMPLES - 1) * PERIOD
    assert abs(max(accels) - (newest - 20_000_000)) <= 1
    places = poses(outputs['delayed', 'pose'])
    for stamp in sorted(accels)[60:]:
        t = (stamp - START) * 1e-9
        q, _ = smooth_motion(6, t)
        assert np.allclose(places[stamp], chain.pose(q), atol=1e-5)


def test_markers_show_the_motion_at_the_tip(outputs):
    places, twists = poses(outputs['plain', 'pose']), by_stamp(outputs['plain', 'twist'])
    assert 20 <= len(outputs['plain', 'markers']) < SAMPLES
    longest = 0
    for message in outputs['plain', 'markers']:
        markers = {m.ns: m for m in message.markers}
        stamp = output_stamp(message)
        tip, twist = places[stamp][:3, 3], twists[stamp]
        arrow = markers['linear_velocity']
        assert arrow.type == Marker.ARROW and arrow.header.frame_id == 'base'
        tail, head = (np.array([p.x, p.y, p.z]) for p in arrow.points)
        assert np.allclose(tail, tip) and np.allclose(np.cross(head - tail, twist[3:]), 0)
        trail = [[p.x, p.y, p.z] for p in markers['trail'].points]
        assert not trail or np.allclose(trail[-1], tip)
        longest = max(longest, len(trail))
        a, b = (np.array([p.x, p.y, p.z]) for p in markers['screw_axis'].points)
        on_axis = shift_pole(twist, a - tip)
        # On the screw axis, velocity is along the axis, and it is the pitch times the rate.
        assert np.allclose(np.cross(on_axis[:3], b - a), 0, atol=1e-9)
        assert np.allclose(np.cross(on_axis[:3], on_axis[3:]), 0, atol=1e-9)
        pitch = on_axis[:3] @ on_axis[3:] / (on_axis[:3] @ on_axis[:3])
        assert markers['pitch'].text == f'pitch {pitch:.4g} m/rad'
    assert longest >= 20

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that change while the node runs: atomically, and without a lost sample."""
from geometry_msgs.msg import AccelStamped, PoseStamped, TwistStamped
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from screw_kinematics import models
from support.rig import joint_state, PUMA, running, six, smooth_motion, stamp_ns

MS = 1_000_000
JOINTS = tuple(f'q{i}' for i in range(1, 7))


@pytest.fixture(scope='module')
def rig(module_context, tmp_path_factory):
    """Run a node with one arm."""
    parameters = {'robots': ['arm'], 'arm': {'description': PUMA}}
    with running(module_context, tmp_path_factory.mktemp('parameters'), parameters) as rig:
        rig.twists = rig.listen('arm/twist', TwistStamped)
        rig.wait_until_serving('arm', ['twist'])
        rig.k = 0
        while not rig.twists:
            stream(rig, 10)
        yield rig


def stream(rig, n):
    """Publish the next n samples of a steady stream."""
    publisher = rig.publisher('joint_states')
    for _ in range(n):
        rig.k += 1
        q, qd = smooth_motion(6, rig.k * 2e-3)
        publisher.publish(joint_state(JOINTS, rig.k * 2 * MS, q, qd))
        rig.spin(0.002)


def stream_until(rig, condition):
    """Publish samples until a condition holds."""
    for _ in range(10_000):
        stream(rig, 5)
        if condition():
            return
    raise AssertionError(rig.log.read_text())


def assert_no_gap(rig, messages):
    """Every sample since the first output has led to an output."""
    rig.wait(lambda: stamp_ns(messages[-1]) == rig.k * 2 * MS)
    assert set(np.diff([stamp_ns(m) for m in messages])) == {2 * MS}


def test_axes_and_prefix_change_at_one_sample_and_none_is_lost(rig):
    chain = models.load(PUMA)
    assert rig.set_parameters(arm__expressed_in='tip', arm__frame_prefix='left/').successful
    stream_until(rig, lambda: rig.twists[-1].header.frame_id == 'left/tool')
    assert rig.set_parameters(arm__expressed_in='base', arm__frame_prefix='').successful
    stream_until(rig, lambda: rig.twists[-1].header.frame_id == 'base')
    assert_no_gap(rig, rig.twists)
    frames = [m.header.frame_id for m in rig.twists]
    assert sum(a != b for a, b in zip(frames, frames[1:])) == 2     # never one without the other
    for message in rig.twists[100:]:
        state = chain.state(*smooth_motion(6, stamp_ns(message) * 1e-9))
        if message.header.frame_id == 'left/tool':
            state = state.expressed_in('tip')
        assert np.allclose(six(message.twist), state.velocity, atol=1e-3)


def test_outputs_come_and_go_beside_the_others(rig):
    assert rig.set_parameters(arm__outputs=['twist', 'pose']).successful
    places = rig.listen('arm/pose', PoseStamped)
    stream_until(rig, lambda: len(places) > 10)
    rig.wait(lambda: rig.node.count_publishers('arm/accel') == 0)
    assert rig.set_parameters(arm__outputs=['twist', 'accel']).successful
    accels = rig.listen('arm/accel', AccelStamped)
    stream_until(rig, lambda: len(accels) > 10)
    rig.wait(lambda: rig.node.count_publishers('arm/pose') == 0)
    # The estimator had been running for the twist: accelerations are good from the first on.
    chain = models.load(PUMA)
    for message in accels:
        t, h = stamp_ns(message) * 1e-9, 1e-4
        (q, qd), (_, a), (_, b) = (smooth_motion(6, t + d) for d in (0, -h, h))
        expected = chain.state(q, qd, (b - a) / (2 * h)).classical(2)
        assert np.allclose(six(message.accel), expected, atol=0.05)
    assert_no_gap(rig, rig.twists)


def test_tool_offset_moves_the_tip_without_a_gap(rig):
    assert rig.set_parameters(arm__tool_offset=[0.0, 0.0, 0.5, 0.0, 0.0, 0.0]).successful
    stream(rig, 50)
    assert_no_gap(rig, rig.twists)
    T = np.eye(4)
    T[2, 3] = 0.5
    state = models.load(PUMA).with_tool(T).state(*smooth_motion(6, rig.k * 2e-3))
    stream_until(rig, lambda: True)
    state = models.load(PUMA).with_tool(T).state(*smooth_motion(6, rig.k * 2e-3))
    rig.wait(lambda: stamp_ns(rig.twists[-1]) == rig.k * 2 * MS)
    assert np.allclose(six(rig.twists[-1].twist), state.velocity, atol=1e-3)


def test_another_delay_takes_effect(rig):
    # No multiple of the period, so that outputs with the delay are known by their stamps.
    assert rig.set_parameters(arm__estimator__delay=0.0213).successful
    stream_until(rig, lambda: abs(stamp_ns(rig.twists[-1]) % (2 * MS) - 700_000) <= 1)
    rig.wait(lambda: abs(stamp_ns(rig.twists[-1]) - (rig.k * 2 * MS - 21_300_000)) <= 1)


@pytest.mark.parametrize('changes, reason', [
    ({'arm__outputs': ['nonsense']}, 'allowed: a list of pose'),
    ({'arm__expressed_in': 'tip', 'arm__tip_frame': 'nowhere'}, "got 'nowhere'"),
    ({'arm__frame_prefix': 'x', 'arm__estimator__delay': 5.0}, 'out of range Min: 0.0, Max: 1.0'),
    ({'arm__description': 'other.yaml'}, 'until the node is unconfigured'),
    ({'robots': ['leg']}, 'until the node is unconfigured'),
    ({'autostart': False}, 'True until the node is started again'),
    ({'qos_overrides./joint_states.subscription.depth': 7},
     "'qos_overrides./joint_states.subscription.depth' is 7; allowed: 5000 until the node is"),
    ({'use_sim_time': 1}, "parameter 'use_sim_time': Wrong parameter type"),
    ({'arm__tool_offset': '[0,0,0.1,0,0,0]'}, 'all written with a point (0.0)'),
    ({'diagnostics_rate': 'often'}, 'a number from 0 to 100')])
def test_a_wrong_change_is_refused_as_a_whole(rig, changes, reason):
    before = len(rig.twists)
    result = rig.set_parameters(**changes)
    assert not result.successful and reason in result.reason
    stream(rig, 20)
    rig.wait(lambda: len(rig.twists) >= before + 20)
    assert {m.header.frame_id for m in rig.twists[before:]} == {'base'}


def test_the_dump_of_the_parameters_can_be_loaded_again(rig):
    """As `ros2 param load` does, with all that is read only."""
    names = rig.call(ListParameters, 'list_parameters', ListParameters.Request()).result.names
    values = rig.call(GetParameters, 'get_parameters', GetParameters.Request(names=names)).values
    request = SetParameters.Request(parameters=[
        ParameterMessage(name=name, value=value) for name, value in zip(names, values)])
    results = rig.call(SetParameters, 'set_parameters', request).results
    assert len(names) > 20 and [result.reason for result in results if not result.successful] == []


def test_rate_of_the_diagnostics(rig):
    assert rig.set_parameters(diagnostics_rate=0.0).successful
    changed = rig.node.get_clock().now().nanoseconds
    rig.spin(0.3)
    reports = rig.received['/diagnostics']
    assert stamp_ns(reports[-1]) <= changed
    n = len(reports)
    assert rig.set_parameters(diagnostics_rate=50.0).successful
    rig.wait(lambda: len(reports) > n + 5)

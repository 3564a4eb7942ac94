# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What would make outputs wrong or missing is told in the diagnostics, and logged."""
import time

from geometry_msgs.msg import TwistStamped
import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from support.rig import joint_state, PUMA, running, smooth_motion

JOINTS = [f'q{k}' for k in range(1, 7)]
YEAR = 365 * 86400
AUTO = "set velocity_source to 'auto', which needs none"
ROBOTS = {
    'never': {'velocity_source': 'measured'},       # gets no velocities
    'zeros': {'velocity_source': 'measured'},       # gets zeros
    'degrees': {},
    'ahead': {}, 'past': {}, 'twice': {}}


@pytest.fixture(scope='module')
def rig(module_context, tmp_path_factory):
    """Give a node with robots that get different streams."""
    parameters = {'robots': list(ROBOTS), 'diagnostics_rate': 10.0}
    for name, own in ROBOTS.items():
        parameters[name] = {'description': PUMA, 'outputs': ['twist'],
                            'joint_states_topic': name, **own}
    with running(module_context, tmp_path_factory.mktemp('told'), parameters) as rig:
        for name in ROBOTS:
            rig.listen(f'/{name}/twist', TwistStamped)
        for name in ROBOTS:
            rig.wait_until_serving(name, ['twist'])
        yield rig


def told(rig, robot, condition, ahead=0.0, velocity=lambda qd: qd, scale=1.0):
    """Publish until the robot's status is as wanted; return it."""
    publisher, k = rig.publisher(f'/{robot}'), 0

    def is_told():
        nonlocal k
        for _ in range(5):
            q, qd = smooth_motion(6, 0.01 * k)
            k += 1
            publisher.publish(joint_state(
                JOINTS, time.time_ns() + round(ahead * 1e9), scale * q, velocity(qd)))
            rig.spin(0.01)
        return condition(*rig.status(robot))
    rig.wait(is_told)
    return rig.status(robot)


def test_measured_velocities_that_never_come(rig):
    told(rig, 'never', lambda level, message, _: level == b'\2' and 'velocity_not' in message
         and AUTO in message, velocity=lambda qd: ())
    assert not rig.received['/never/twist']
    rig.wait(lambda: f'never: velocity_not_measured (velocity_source is \'measured\': {AUTO})'
             in rig.log.read_text())


def test_measured_velocities_that_are_zero_while_the_joints_move(rig):
    told(rig, 'zeros', lambda level, message, _: level == b'\1' and AUTO in message
         and 'zero while they move' in message, velocity=lambda qd: 0 * qd)
    rig.wait(lambda: 'zeros: velocity_source is' in rig.log.read_text())


def test_positions_in_degrees(rig):
    told(rig, 'degrees', lambda level, message, _: 'are these degrees' in message, scale=57.3)


@pytest.mark.parametrize('robot, seconds, words', [
    ('ahead', YEAR, 'ahead'), ('past', 5e6 - time.time(), 'old')], ids=['ahead', 'past'])
def test_stamps_of_another_clock(rig, robot, seconds, words):
    _, _, values = told(rig, robot, lambda level, message, _: level == b'\1' and
                        'stamps are not of this clock' in message and words in message, seconds)
    assert values['age of last output [s]'] == 'not of this clock'
    rig.wait(lambda: rig.status(robot)[2]['output rate [Hz]'] == '0.0')     # nor when none comes
    assert rig.status(robot)[2]['age of last output [s]'] == 'not of this clock'


@pytest.mark.parametrize('name', ['', 'nope', 'arm.', '.', 'never.nope'])
def test_parameters_that_do_not_exist_are_refused_and_others_set(rig, name):
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value='x')
    rate = Parameter(name='diagnostics_rate', value=ParameterValue(
        type=ParameterType.PARAMETER_DOUBLE, double_value=10.0))
    given = [Parameter(name=name, value=value), rate, Parameter(name=name, value=value)]
    for _ in range(2):      # nor does the refusal make it exist
        results = rig.call(SetParameters, 'set_parameters',
                           SetParameters.Request(parameters=given)).results
        assert [r.successful for r in results] == [False, True, False]
        assert f'parameter {name!r} does not exist' in results[0].reason
        result = rig.call(SetParametersAtomically, 'set_parameters_atomically',
                          SetParametersAtomically.Request(parameters=given)).result
        assert not result.successful and f'{name!r} does not exist' in result.reason


def test_joints_named_twice_are_told_and_not_that_joints_are_missing(rig):
    publisher, names, k = rig.publisher('/twice'), [*JOINTS[:5], 'q1'], 0

    def logged():
        nonlocal k
        for _ in range(5):
            publisher.publish(joint_state(names, time.time_ns(), smooth_motion(6, 0.01 * k)[0]))
            k += 1
            rig.spin(0.01)
        return 'twice: joint_named_twice' in rig.log.read_text()
    rig.wait(logged)
    rig.wait(lambda: logged() and k > 600)
    level, message, _ = rig.status('twice', 'every message is refused: joint_named_twice')
    assert level == b'\2' and message
    assert 'twice: no joint states' not in rig.log.read_text()

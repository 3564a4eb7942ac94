# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Nothing that another node sends ends this one: every service, values of every kind."""
from contextlib import suppress

from lifecycle_msgs.srv import (
    ChangeState, GetAvailableStates, GetAvailableTransitions, GetState)
import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters, GetParameters, GetParameterTypes, ListParameters, SetParameters,
    SetParametersAtomically)
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from support.rig import NODE, PUMA, running
from type_description_interfaces.srv import GetTypeDescription

EXECUTORS = ('events', 'single_threaded')
NAMES = ('', 'robots', 'arm.outputs', 'arm.estimator.delay', 'use_sim_time', '.', 'nothing',
         'qos_overrides./arm/twist.publisher.depth', 'diagnostics_rate', 'x' * 300, 'ä\n')
VALUES = (
    ParameterValue(type=ParameterType.PARAMETER_NOT_SET),
    ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True),
    ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=-2**63),
    ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=float('nan')),
    ParameterValue(type=ParameterType.PARAMETER_STRING, string_value='ä\n' * 100),
    ParameterValue(type=ParameterType.PARAMETER_BYTE_ARRAY, byte_array_value=[b'\0', b'\xff']),
    ParameterValue(type=ParameterType.PARAMETER_DOUBLE_ARRAY,
                   double_array_value=[float('inf')] * 6),
    ParameterValue(type=ParameterType.PARAMETER_STRING_ARRAY, string_array_value=['', 'twist']),
    ParameterValue(type=11), ParameterValue(type=255))
SERVICES = {
    'change_state': ChangeState, 'get_state': GetState,
    'get_available_states': GetAvailableStates,
    'get_available_transitions': GetAvailableTransitions,
    'get_transition_graph': GetAvailableTransitions,
    'describe_parameters': DescribeParameters, 'get_parameters': GetParameters,
    'get_parameter_types': GetParameterTypes, 'list_parameters': ListParameters,
    'set_parameters': SetParameters, 'set_parameters_atomically': SetParametersAtomically,
    'get_type_description': GetTypeDescription}


def parameters(executor, **others):
    return {'robots': ['arm'], 'executor': executor,
            'arm': {'description': PUMA}, **others}


def change(rig, number, label=''):
    request = ChangeState.Request()
    request.transition.id, request.transition.label = number, label
    return rig.call(ChangeState, 'change_state', request).success


def state(rig):
    return rig.call(GetState, 'get_state', GetState.Request()).current_state.label


@pytest.mark.parametrize('executor', EXECUTORS)
def test_transitions_that_are_not_possible_are_refused_and_told(context, tmp_path, executor):
    with running(context, tmp_path, parameters(executor)) as rig:
        deactivate = 4
        # Those of ids 5, 6, 7 shut down: from this state only the last of them is possible.
        impossible = [n for n in range(256) if n not in (deactivate, 7)]
        assert not any(change(rig, number) for number in impossible)
        assert not any(change(rig, deactivate, label) for label in ('configure', 'no such', 'ä'))
        assert state(rig) == 'active'
        log = rig.log.read_text()
        assert ('transition 1 is not possible now; possible: '
                "4 'deactivate', 7 'shutdown'") in log
        assert "transition 'no such' is not possible" in log
        # What is possible still is.
        assert change(rig, 0, 'deactivate') and state(rig) == 'inactive'
        assert change(rig, 3) and state(rig) == 'active'
        assert change(rig, 7) and not change(rig, 1)
        rig.wait(lambda: 'possible: none, the node is shut down' in rig.log.read_text())


@pytest.mark.parametrize('executor', EXECUTORS)
def test_requests_with_any_values_are_answered(context, tmp_path, executor):
    with running(context, tmp_path, parameters(executor)) as rig:
        for service in ('describe_parameters', 'get_parameters', 'get_parameter_types'):
            kind = SERVICES[service]
            rig.call(kind, service, kind.Request(names=list(NAMES)))
            for name in NAMES:
                rig.call(kind, service, kind.Request(names=[name]))
        for depth in (0, 1, 2**64 - 1):
            rig.call(ListParameters, 'list_parameters',
                     ListParameters.Request(prefixes=list(NAMES), depth=depth))
        for hash_text in ('', 'RIHS01_' + '0' * 64, 'ä'):
            rig.call(GetTypeDescription, 'get_type_description', GetTypeDescription.Request(
                type_name='sensor_msgs/msg/JointState', type_hash=hash_text))
        for name in NAMES:
            given = [Parameter(name=name, value=value) for value in VALUES]
            results = rig.call(SetParameters, 'set_parameters',
                               SetParameters.Request(parameters=given)).results
            assert len(results) == len(given)
            assert all(result.successful or result.reason for result in results)
            for parameter in given:
                result = rig.call(
                    SetParametersAtomically, 'set_parameters_atomically',
                    SetParametersAtomically.Request(parameters=[parameter])).result
                assert result.successful or result.reason
        given = [Parameter(name='arm.estimator.dealy', value=ParameterValue(
            type=ParameterType.PARAMETER_DOUBLE, double_value=0.01))]
        told = ("parameter 'arm.estimator.dealy' does not exist; "
                "did you mean 'arm.estimator.delay'?")
        assert [told] == [result.reason for result in rig.call(
            SetParameters, 'set_parameters', SetParameters.Request(parameters=given)).results]
        assert told == rig.call(SetParametersAtomically, 'set_parameters_atomically',
                                SetParametersAtomically.Request(parameters=given)).result.reason
        assert state(rig) == 'active'


@pytest.mark.parametrize('executor', EXECUTORS)
def test_messages_that_are_no_messages_are_passed_over(context, tmp_path, executor):
    described = {'description': '', 'description_topic': 'described'}
    settings = parameters(executor, robots=['arm', 'other'], other=described, use_sim_time=True)
    junk = (b'\0\1\0\0', b'\0\1\0\0\xff\xff\xff\xff', bytes(64), b'\xff' * 64,
            b'\0\1\0\0\2\0\0\0\xff\0\0\0')    # the last one is a String that is not UTF-8
    with running(context, tmp_path, settings) as rig:
        for publisher in (
                rig.publisher('joint_states'),
                rig.publisher('described', String, QoSProfile(
                    depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)),
                rig.publisher('/clock', Clock, QoSProfile(
                    depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))):
            for data in junk:
                # Types of bounded size cannot be sent longer than that.
                with suppress(RuntimeError):
                    publisher.handle.publish_raw(data)
                rig.spin(0.05)
        assert [state(rig) for _ in junk] == ['active'] * len(junk)
        # A time that rclpy has no number for.
        clock = rig.publisher('/clock')
        before_1970 = Clock()
        before_1970.clock.sec = -1
        while 'passed over' not in rig.log.read_text():
            clock.publish(before_1970)
            rig.spin(0.05)
        assert state(rig) == 'active'


@pytest.mark.parametrize('executor', EXECUTORS)
def test_requests_that_are_no_requests_are_passed_over(context, tmp_path, executor):
    """They come from a participant without ROS, as no client of ROS can send them."""
    pytest.importorskip('cyclonedds')
    from support.foreign_participant import ForeignParticipant
    with running(context, tmp_path, parameters(executor)) as rig:
        with ForeignParticipant() as foreign:
            for service, kind in SERVICES.items():
                writer = foreign.writer(f'rq/{NODE}/{service}Request', kind.Request)
                rig.wait(writer.matched)
                for content in (b'', b'\xff' * 8, b'\xff' * 200, bytes(3), b'\0\0\0\x80' * 40):
                    writer.write(content)
                    rig.spin(0.02)
        assert state(rig) == 'active'
        assert change(rig, 4) and state(rig) == 'inactive'

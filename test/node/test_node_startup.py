# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong at start is told in one readable line, and the node does not run."""
import pytest
from rclpy.parameter import Parameter
from screw_kinematics.errors import ScrewKinematicsError
from screw_kinematics.node.node import KinematicStatePublisher
from support.rig import PUMA

GOOD = {'robots': ['arm'], 'arm.description': PUMA}
BROKEN = '<robot name="r"><link name="a"/><joint name="j" type="revolute"></robot>'
PLANAR = ('<robot name="r"><link name="a"/><link name="b"/><joint name="slide" type="planar">'
          '<parent link="a"/><child link="b"/></joint></robot>')

WRONG = [
    ({}, r"'robots' is \[\]; allowed: names of robots, and a description for each"),
    ({'robots': ['arm', 'arm']}, "'robots' is .*allowed: different names"),
    ({'robots': ['1st/arm']}, "'robots' is .*allowed: different names of letters"),
    ({'robots': 7}, "'robots' is 7; allowed"),
    ({'diagnostics_rate': -1.0}, "'diagnostics_rate' is -1.0; allowed: a number from 0 to 100"),
    ({'arm.outputs': ['twist', 'twits']}, "'arm.outputs' is .*'twits'.*allowed: a list of pose"),
    ({'arm.outputs': 'twist'}, "'arm.outputs' is 'twist'; allowed: a list of"),
    ({'arm.expressed_in': 'world'}, "'arm.expressed_in' is 'world'; allowed: one of base, tip"),
    ({'arm.tool_offset': [0.1, 0.2]}, "'arm.tool_offset' is .*allowed: six finite numbers"),
    ({'arm.tool_offset': [float('nan')] * 6}, "'arm.tool_offset' is .*six finite numbers"),
    ({'arm.velocity_source': 'guess'}, 'allowed: one of auto, measured, estimated'),
    ({'arm.estimator.delay': 3.0}, "'arm.estimator.delay' is 3.0; allowed: a number from 0 to 1"),
    ({'arm.estimator.delay': 'long'}, "'arm.estimator.delay' is 'long'; allowed: a number"),
    ({'arm.estimator.delay': 0.02, 'arm.velocity_source': 'measured'},
     "'arm.estimator.delay' is 0.02; allowed: 0, as velocity_source 'measured'"),
    ({'arm.estimator.kind': 'magic'}, "'arm.estimator.kind' is 'magic'; allowed: one of bank"),
    ({'arm.estimator.kind': 'finite_difference', 'arm.estimator.delay': 0.02},
     "'arm.estimator.delay' is 0.02; allowed: at most 0 with estimator.kind 'finite_difference'"),
    ({'arm.base_frame': 7}, "'arm.base_frame' is 7; allowed: a frame of the model"),
    ({'arm.joint_states_topic': ''}, "'arm.joint_states_topic' is ''; allowed: a topic name"),
    ({'arm.joint_states_topic': 'joint states'}, "'arm.joint_states_topic'.*'joint states'"),
    ({'arm.tip_frame': 'nowhere'}, "puma560.yaml: tip_frame: got 'nowhere'"),
    ({'qos_overrides./joint_states.subscription.reliability': 'perhaps'}, "'?perhaps'?"),
    ({'qos_overrides./arm/twist.publisher.depth': 'deep'}, 'qos_overrides./arm/twist.*deep'),
    ({'arm.description': '/no/such.urdf'}, '/no/such.urdf: no such file'),
    ({'arm.description': BROKEN}, "parameter 'arm.description': "),
    ({'arm.description': PLANAR}, "parameter 'arm.description': .*'slide'.*planar"),
]


def make(context, parameters):
    """Make a node in this process."""
    return KinematicStatePublisher(context=context, parameter_overrides=[
        Parameter(name, value=value) for name, value in parameters.items()])


@pytest.mark.parametrize('changes, message', WRONG)
def test_wrong_parameters_and_models_are_told_with_what_is_allowed(
        module_context, changes, message):
    parameters = {**GOOD, **changes} if changes else {}
    with pytest.raises(ScrewKinematicsError, match=message) as raised:
        make(module_context, parameters)
    assert '\n' not in str(raised.value)


def test_whole_numbers_are_numbers(module_context):
    node = make(module_context, {
        **GOOD, 'diagnostics_rate': 2, 'arm.estimator.delay': 0, 'arm.tool_offset': [0] * 6})
    assert node.robots['arm'].settings.motion.delay == 0.0
    node.destroy_node()


@pytest.mark.parametrize('name, value, told', [
    ('arm.outptus', 'x', "'arm.outptus' does not exist; did you mean 'arm.outputs'"),
    ('qos_overrides./joint_state.subscription.depth', 5,
     "did you mean 'qos_overrides./joint_states.subscription.depth'"),
    ('qos_overrides./joint_states.subscription.durability', 'volatile',
     'of this topic: qos_overrides./joint_states.subscription.depth, '
     'qos_overrides./joint_states.subscription.history, '),
    ('qos_overrides./arm/twist.subscription.depth', 5,
     'of this topic: qos_overrides./arm/twist.publisher.depth, '),
    ('hand.description', 'x', "'hand.description' does not exist")])
def test_misspelt_parameters_are_reported(module_context, name, value, told):
    node = make(module_context, {**GOOD, name: value})
    assert len(node.unknown_parameters) == 1 and told in node.unknown_parameters[0]
    node.destroy_node()


def test_every_parameter_is_described(module_context):
    node = make(module_context, GOOD)
    for name in ('robots', 'diagnostics_rate', 'arm.description', 'arm.outputs',
                 'arm.estimator.delay', 'arm.velocity_source'):
        descriptor = node.describe_parameter(name)
        assert descriptor.description and 'Allowed: ' in descriptor.additional_constraints
    span, = node.describe_parameter('arm.estimator.delay').floating_point_range
    assert (span.from_value, span.to_value) == (0.0, 1.0)
    assert 'Set at start only' in node.describe_parameter('autostart').additional_constraints
    node.destroy_node()

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A managed node: what a lifecycle manager does with it, over DDS."""
from geometry_msgs.msg import TwistStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import ListParameters
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from screw_kinematics.messages.joint_state import JointSample
from screw_kinematics.node.node import KinematicStatePublisher
from support.rig import joint_state, PUMA, running, smooth_motion

MS = 1_000_000
JOINTS = tuple(f'q{i}' for i in range(1, 7))


def change(rig, transition):
    """Ask for a transition; return whether it succeeded."""
    request = ChangeState.Request()
    request.transition.id = transition
    return rig.call(ChangeState, 'change_state', request).success


def state(rig):
    """Return the name of the present state."""
    return rig.call(GetState, 'get_state', GetState.Request()).current_state.label


def test_the_whole_life(context, tmp_path):
    parameters = {'robots': ['arm'], 'autostart': False,
                  'arm': {'description': '/no/such/file.urdf', 'velocity_source': 'measured'}}
    q, qd = smooth_motion(6, 0.0)
    with running(context, tmp_path, parameters) as rig:
        assert state(rig) == 'unconfigured'
        # A failing configuration is told, and can be tried again.
        assert not change(rig, Transition.TRANSITION_CONFIGURE)
        assert state(rig) == 'unconfigured'
        rig.wait(lambda: rig.status('node')[0] == b'\2')
        assert 'no such file' in rig.status('node')[1]
        assert "cannot become inactive: robot 'arm': /no/such/file.urdf" in rig.log.read_text()
        assert rig.set_parameters(arm__description=PUMA).successful
        assert change(rig, Transition.TRANSITION_CONFIGURE)
        assert state(rig) == 'inactive'

        twists = rig.listen('arm/twist', TwistStamped)
        rig.wait_until_serving('arm', ['twist'])
        assert rig.node.count_subscribers('joint_states') == 0
        for turn in range(2):
            assert change(rig, Transition.TRANSITION_ACTIVATE)
            publisher = rig.publisher('joint_states')
            rig.wait(lambda: publisher.get_subscription_count() == 1)
            n, k = len(twists), 0
            while len(twists) == n:
                k += 1
                publisher.publish(joint_state(JOINTS, (turn * 10_000 + k) * MS, q, qd))
                rig.spin(0.01)
            assert change(rig, Transition.TRANSITION_DEACTIVATE)
            assert state(rig) == 'inactive'
            rig.wait(lambda: publisher.get_subscription_count() == 0)

        refused = rig.set_parameters(arm__description='elsewhere.urdf')
        assert not refused.successful and 'until the node is unconfigured' in refused.reason
        assert change(rig, Transition.TRANSITION_CLEANUP)
        assert state(rig) == 'unconfigured'
        rig.wait(lambda: rig.node.count_publishers('arm/twist') == 0)
        assert change(rig, Transition.TRANSITION_CONFIGURE)
        assert change(rig, Transition.TRANSITION_ACTIVATE)
        assert change(rig, Transition.TRANSITION_ACTIVE_SHUTDOWN)
        assert state(rig) == 'finalized'


def test_robots_may_be_named_and_described_before_they_are_configured(context, tmp_path):
    with running(context, tmp_path, {'autostart': False}) as rig:
        assert not change(rig, Transition.TRANSITION_CONFIGURE)
        assert 'names of robots' in rig.log.read_text()
        assert rig.set_parameters(robots=['arm']).successful
        assert rig.set_parameters(arm__description=PUMA).successful
        assert change(rig, Transition.TRANSITION_CONFIGURE)
        rig.wait(lambda: rig.node.count_publishers('arm/twist') == 1)


def test_parameters_are_not_offered_if_so_asked(context, tmp_path):
    parameters = {'robots': ['arm'], 'allow_remote_parameters': False,
                  'arm': {'description': PUMA}}
    with running(context, tmp_path, parameters) as rig:
        assert state(rig) == 'active'
        client = rig.node.create_client(
            ListParameters, 'kinematic_state_publisher/list_parameters')
        rig.wait(lambda: rig.node.count_publishers('arm/twist') == 1)
        services = dict(rig.node.get_service_names_and_types_by_node(
            'kinematic_state_publisher', '/'))
        assert not client.service_is_ready()
        assert not any('parameter' in name for name in services), services


def test_diagnostics_begin_anew_with_every_configuration(context):
    node = KinematicStatePublisher(context=context, parameter_overrides=[
        Parameter('robots', value=['arm']), Parameter('arm.description', value=PUMA)])

    def take(count):
        for k in range(count):
            node.robots['arm'].take(JointSample(10**9 + k * MS, JOINTS, (0.1,) * 6, ()))
        return node.report().status[1]

    assert (take(20).level, take(20).level) == (b'\0', b'\0')
    for transition in (node.trigger_deactivate, node.trigger_cleanup, node.trigger_configure,
                       node.trigger_activate):
        assert transition() == TransitionCallbackReturn.SUCCESS
    status = take(10)
    assert (status.level, status.message) == (b'\0', 'ready; nobody listens')
    node.destroy_node()


def test_diagnostics_of_nodes_in_different_namespaces_differ(context):
    for namespace, node_name, hardware in (
            ('', '/kinematic_state_publisher', 'arm'),
            ('cell', '/cell/kinematic_state_publisher', 'cell/arm')):
        node = KinematicStatePublisher(
            context=context, namespace=namespace, parameter_overrides=[
                Parameter('robots', value=['arm']), Parameter('arm.description', value=PUMA)])
        assert [(status.name, status.hardware_id)
                for status in node.report().status] == [
            (f'{node_name}: node', 'none'), (f'{node_name}: arm', hardware)]
        node.destroy_node()

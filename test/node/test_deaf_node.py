# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A node whose ports in shared memory were deleted joins the middleware anew."""
import os
from pathlib import Path
from threading import Event

from geometry_msgs.msg import AccelStamped, TwistStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
import pytest
from rcl_interfaces.msg import Log
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from screw_kinematics.node.node import KinematicStatePublisher
from screw_kinematics.node.own_ports import OwnPorts
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from support.rig import joint_state, PUMA, running, smooth_motion
from support.urdf import joint, robot

JOINTS = [f'q{k}' for k in range(1, 7)]


def deafen(rig):
    """Delete the node's ports, as publishers do of a process that stood still; return them."""
    ports = OwnPorts(Path(f'/proc/{rig.process.pid}')).names
    if not ports:
        pytest.skip('the middleware has no ports in shared memory')
    for port in ports:
        os.unlink(port)
    rig.wait(lambda: 'joined the middleware anew' in rig.status('node')[2])
    assert rig.process.poll() is None and 'deaf' in rig.log.read_text()
    return ports


@pytest.mark.parametrize('executor', ['events', 'single_threaded'])
def test_a_deaf_node_goes_on_where_it_was_and_says_so(context, tmp_path, executor):
    parameters = {
        'robots': ['arm'], 'diagnostics_rate': 10.0, 'executor': executor,
        'arm': {'description': PUMA, 'velocity_source': 'measured', 'outputs': ['twist']}}
    with running(context, tmp_path, parameters, ['-p', 'arm.speed:=1.0']) as rig:
        twists = rig.listen('/arm/twist', TwistStamped)
        k = 0

        def heard(publisher):
            before = len(twists)

            def send():
                nonlocal k
                k += 1
                publisher.publish(joint_state(JOINTS, k * 2_000_000, *smooth_motion(6, k * 2e-3)))
                return len(twists) > before
            rig.wait(send)

        heard(rig.publisher('/joint_states'))
        assert rig.set_parameters(arm__stale_timeout=7.0).successful
        ports = deafen(rig)
        # One that comes now finds the node, which is as it was left.
        heard(rig.node.create_publisher(JointState, '/joint_states', QoSProfile(depth=20)))
        values = rig.call(GetParameters, 'get_parameters', GetParameters.Request(
            names=['arm.stale_timeout'])).values
        assert values[0].double_value == 7.0
        # What was logged at the start is not logged again; in the diagnostics it still stands.
        for line in ("parameter 'arm.speed' does not exist", 'arm: SerialChain(', 'the core is '):
            assert rig.log.read_text().count(line) == 1
        assert "parameter 'arm.speed' does not exist" in rig.status('node')[1]
        # The one before it is let go of, and what it held of the middleware.
        maps = Path(f'/proc/{rig.process.pid}/maps')
        rig.wait(lambda: not any(f'{port} (deleted)' in maps.read_text() for port in ports))
        # And what is logged is still published.
        logged = rig.listen('/rosout', Log)
        rig.call(ChangeState, 'change_state', ChangeState.Request(
            transition=Transition(id=Transition.TRANSITION_CONFIGURE)))
        rig.wait(lambda: any('is not possible now' in message.msg for message in logged))


def test_what_a_node_has_heard_and_counted_goes_on(context, tmp_path):
    parameters = {'robots': ['arm'], 'diagnostics_rate': 10.0,
                  'arm': {'outputs': ['twist', 'accel']}}
    with running(context, tmp_path, parameters) as rig:
        twists = rig.listen('/arm/twist', TwistStamped)
        accels = rig.listen('/arm/accel', AccelStamped)
        k = 0

        def describe(base):
            publisher = rig.node.create_publisher(String, '/robot_description', QoSProfile(
                depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
            publisher.publish(String(data=robot(f'{base} tip', joint('q1', base, 'tip'))))
            rig.wait(lambda: base in rig.status('arm')[2].get('model', ''))
            rig.node.destroy_publisher(publisher)   # so that nobody says it again

        def heard(publisher, base):
            accels.clear()

            def send():
                nonlocal k
                k += 1
                publisher.publish(joint_state(['q1'], k * 2_000_000, *smooth_motion(1, k * 2e-3)))
                return accels and {m.header.frame_id for m in (accels[-1], twists[-1])} == {base}
            rig.wait(send)

        def counts():
            arm, topic = rig.status('arm')[2], rig.status('node')[2]
            assert int(arm['received']) == int(arm['used']) + int(arm['refused'])
            assert arm['received'] == topic['/joint_states received']
            return int(arm['received']), arm.get('used estimator_settling')

        publisher = rig.publisher('/joint_states')
        describe('first')
        heard(publisher, 'first')
        rig.wait(lambda: counts()[0] == k)
        deafen(rig)
        assert counts()[0] == k
        before, settling = counts()
        heard(rig.node.create_publisher(JointState, '/joint_states', 20), 'first')
        rig.wait(lambda: counts()[0] > before)
        assert counts()[1] == settling is not None
        describe('second')
        heard(publisher, 'second')


@pytest.mark.parametrize('transitions, state', [
    ((), 'active'), (('deactivate',), 'inactive'), (('deactivate', 'cleanup'), 'unconfigured'),
    (('shutdown',), 'finalized')])
def test_the_next_node_is_in_the_state_of_the_one_before(context, transitions, state):
    first = KinematicStatePublisher(context=context, parameter_overrides=[
        Parameter('robots', value=['arm']), Parameter('arm.description', value=PUMA),
        Parameter('arm.speed', value=1.0)])
    for transition in transitions:
        getattr(first, f'trigger_{transition}')()
    before = first.hand_over()
    assert before.state == state
    first.destroy_node()
    second = KinematicStatePublisher(before, context=context)
    assert second.state == state
    assert second.get_parameter('arm.description').value == PUMA
    # What the user gave and what does not exist is still told, and nothing else.
    assert second.unknown_parameters == first.unknown_parameters
    assert len(first.unknown_parameters) == 1 and 'arm.speed' in first.unknown_parameters[0]
    second.destroy_node()


def test_where_no_other_node_follows_all_work_is_let_go(context):
    node = KinematicStatePublisher(context=context, parameter_overrides=[
        Parameter('autostart', value=False)])
    before, asked = node.hand_over(), Event()
    before.worker.submit('work', asked.wait, print, print)
    assert before.worker.pending == 1
    before.end()
    asked.set()
    assert before.worker.pending == 0


def test_a_port_that_is_opened_anew_is_heard(tmp_path, monkeypatch):
    """Of what the system tells of a process; deaf is who holds a nameless port for a while."""
    port, process = tmp_path / 'fastrtps_port7411', tmp_path / 'process'
    port.write_text('')
    (process / 'fd').mkdir(parents=True)
    (process / 'fd' / '9').symlink_to(f'{port}_el')
    now = [0.0]
    monkeypatch.setattr('screw_kinematics.node.own_ports.monotonic', lambda: now[0])

    def look(listens_to, seconds):
        (process / 'maps').write_text(f'7f00-7f01 rw-s 0 00:1b 5   {listens_to}\n')
        now[0] += seconds
        return ports.deaf()

    ports = OwnPorts(process)
    assert look(port, 1.0) == []
    port.rename(tmp_path / 'kept')      # so that the next one is another file
    port.write_text('')
    assert look(f'{port} (deleted)', 1.0) == []
    assert look(port, 2.0) == []        # another one, opened in time
    port.unlink()
    assert look(f'{port} (deleted)', 1.0) == []
    assert look(f'{port} (deleted)', 2.0) == [str(port)]
    assert OwnPorts(tmp_path / 'nothing').deaf() == []

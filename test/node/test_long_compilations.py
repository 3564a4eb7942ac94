# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""While descriptions of hundreds of joints are compiled, other robots neither wait nor lose."""
import time

from geometry_msgs.msg import AccelStamped, TwistStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from support.rig import joint_state, PUMA, running, smooth_motion

N_LONG = 2
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
OUTPUTS = ['twist', 'accel', 'jerk', 'snap']


def chain(name, n):
    """Return a URDF of n skew joints."""
    joints = ''.join(
        f'<link name="{name}_{k + 1}"/><joint name="{name}_j{k}" type="revolute">'
        f'<parent link="{name}_{k}"/><child link="{name}_{k + 1}"/>'
        f'<origin xyz="0.1 0.02 0.3" rpy="{0.1 * k} 0.5 {0.3 * k}"/><axis xyz="1 {k} 2"/>'
        '<limit lower="-3" upper="3" velocity="3" effort="1"/></joint>' for k in range(n))
    return f'<robot name="{name}"><link name="{name}_0"/>{joints}</robot>'


def test_robots_that_stream_and_those_that_come_meanwhile_are_served(context, tmp_path):
    long = [f'long_{k}' for k in range(N_LONG)]
    parameters = {'robots': ['arm', 'late', *long],
                  'arm': {'description': PUMA, 'joint_states_topic': 'arm', 'outputs': ['accel']},
                  'late': {'description_topic': 'late_described', 'outputs': ['accel']}}
    for name in long:
        parameters[name] = {'description_topic': 'long_described', 'outputs': OUTPUTS}
    with running(context, tmp_path, parameters) as rig:
        outputs = rig.listen('/arm/accel', AccelStamped)
        late = rig.listen('/late/accel', AccelStamped)
        for name in long:
            for output in OUTPUTS:
                rig.listen(f'/{name}/{output}', TwistStamped if output == 'twist'
                           else AccelStamped)
        rig.wait_until_serving('arm', ['accel'])
        arm, states = rig.publisher('arm'), rig.publisher('joint_states')
        descriptions = {topic: rig.node.create_publisher(String, topic, LATCHED)
                        for topic in ('long_described', 'late_described')}
        start, sent = time.time_ns(), 0

        def stream():
            nonlocal sent
            q, qd = smooth_motion(6, 0.005 * sent)
            stamp = start + sent * 5_000_000
            arm.publish(joint_state([f'q{k}' for k in range(1, 7)], stamp, q))
            states.publish(joint_state(['late_j0', 'late_j1'], stamp, q[:2]))
            sent += 1
            rig.spin(0.005)

        def compiling():
            return [name for name in long if 'at work' in rig.status(name)[2]]

        descriptions['long_described'].publish(String(data=chain('long', 200)))
        descriptions['late_described'].publish(String(data=chain('late', 2)))
        rig.wait(lambda: stream() or late)
        assert compiling(), 'it came while others were compiled'
        rig.wait(lambda: stream() or not compiling())
        rig.wait(lambda: len(outputs) == sent - 7)
        assert rig.status('arm')[2]['lost by their stamps'] == '0'

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A node in its own process, and a node here that talks to it over DDS."""
from contextlib import contextmanager
import json
import os
import subprocess
import sys
import time

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
import numpy as np
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from screw_kinematics.pipeline.parameter_file import read_robots
from sensor_msgs.msg import JointState

LIMIT = 90.0
"""Seconds to wait for a condition, generous for busy machines."""

KEEP = QoSProfile(depth=20000)
DEEP = RELIABLE_INPUT = {'reliability': 'reliable', 'depth': 5000}
"""Of what nothing may be lost."""

NODE = 'kinematic_state_publisher'
CODE = 'import sys; from screw_kinematics.node.main import main; sys.exit(main())'
"""What the process of the node runs."""


class Rig:
    """
    A running node and its surroundings.

    Counts can be compared whatever else the machine does: where a test does not say otherwise
    no robot falls silent, and of joint states and outputs nothing is lost.

    Parameters
    ----------
    context : rclpy.Context
    directory : Path
        For the file of parameters.
    parameters : dict
        Of the node, nested as in a file.
    arguments : sequence of str
        Further ROS arguments.

    """

    def __init__(self, context, directory, parameters, arguments=()):
        file = directory / 'parameters.yaml'
        write(file, parameters)
        write(file, patient(parameters, file))
        self.log = directory / 'log.txt'
        self.node = rclpy.create_node('rig', context=context)
        self.executor = EventsExecutor(context=context)
        self.executor.add_node(self.node)
        self.received = {}
        self._publishers = {}
        self._clients = {}
        self.process = start(['--params-file', str(file), *arguments], self.log)
        self.listen('/diagnostics', DiagnosticArray)

    def listen(self, topic, kind):
        """Collect the messages of a topic; return the list of them."""
        if topic not in self.received:
            messages = self.received[topic] = []
            self.node.create_subscription(kind, topic, messages.append, KEEP)
        return self.received[topic]

    def publisher(self, topic, kind=JointState, qos=KEEP):
        """Return a publisher that the node has found."""
        if topic not in self._publishers:
            publisher = self._publishers[topic] = self.node.create_publisher(kind, topic, qos)
            self.wait(lambda: publisher.get_subscription_count() > 0)
            # To have found the node is not yet to be found by it.
            self.wait(lambda: self.status('node')[2].get(f'/{topic} publishers') != '0')
        return self._publishers[topic]

    def spin(self, seconds):
        """Take what has arrived."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self.executor.spin_once(deadline - time.monotonic())

    def wait(self, condition, limit=LIMIT):
        """Wait for a condition; fail after the limit, with the node's log."""
        deadline = time.monotonic() + limit
        while not condition():
            assert time.monotonic() < deadline, f'waited in vain; log: {self.log.read_text()}'
            assert self.process.poll() is None, f'node ended; log: {self.log.read_text()}'
            self.executor.spin_once(0.05)

    def status(self, part, told=''):
        """Return level, message and values of the latest diagnostics of a part that told this."""
        for array in reversed(self.received['/diagnostics']):
            for status in array.status:
                if status.name == f'/{NODE}: {part}' and told in status.message:
                    return status.level, status.message, {v.key: v.value for v in status.values}
        return None, '', {}

    def wait_for_value(self, part, key, value):
        """Wait until the diagnostics of a part have this value."""
        self.wait(lambda: self.status(part)[2].get(key) == str(value))

    def wait_until_serving(self, robot, outputs):
        """Wait until the node knows that these outputs of a robot are listened to."""
        self.wait_for_value(robot, 'outputs listened to', ', '.join(outputs))

    def call(self, kind, service, request):
        """Call a service of the node."""
        client = self._clients.get(service)
        if client is None:
            client = self._clients[service] = self.node.create_client(kind, f'{NODE}/{service}')
            self.wait(client.service_is_ready)
        future = client.call_async(request)
        self.wait(future.done)
        return future.result()

    def set_parameters(self, **values):
        """Set parameters atomically ('__' stands for '.'); return the result."""
        from rcl_interfaces.srv import SetParametersAtomically
        request = SetParametersAtomically.Request(parameters=[
            Parameter(name.replace('__', '.'), value=value).to_parameter_msg()
            for name, value in values.items()])
        return self.call(
            SetParametersAtomically, 'set_parameters_atomically', request).result

    def close(self):
        """End the node; it must end well."""
        self.process.terminate()
        try:
            code = self.process.wait(30)
        finally:
            self.process.kill()
            self.node.destroy_node()
            self.executor.shutdown()
        log = self.log.read_text()
        assert code == 0 and 'Traceback' not in log, log


def write(file, parameters):
    """Write a file of parameters."""
    file.write_text(json.dumps({NODE: {'ros__parameters': parameters}}))     # JSON is YAML


def patient(parameters, file):
    """Return parameters, written in a file, with which it is no matter how long things take."""
    parameters, qos = {'diagnostics_rate': 20.0, **parameters}, {}
    if parameters.get('robots'):
        for robot in read_robots(file):
            qos |= {f'/{topic}': {'subscription': DEEP} for topic in robot.joint_states_topic}
            qos |= {f'/{robot.topic}/{output}': {'publisher': DEEP} for output in robot.outputs}
            if robot.base_motion_topic:
                qos[f'/{robot.base_motion_topic}'] = {'subscription': DEEP}
        for name in parameters['robots']:
            parameters[name] = {'stale_timeout': 1000.0, **parameters[name]}
    qos |= parameters.get('qos_overrides', {})
    return parameters | ({'qos_overrides': qos} if qos else {})


@contextmanager
def running(context, directory, parameters, arguments=()):
    """Give a rig whose node runs; end it."""
    rig = Rig(context, directory, parameters, arguments)
    try:
        rig.wait(lambda: rig.status('node')[0] is not None
                 and NODE in rig.node.get_node_names())
        yield rig
    finally:
        rig.close()


def start(arguments, log):
    """Start the node."""
    with open(log, 'w') as file:
        return subprocess.Popen(
            [sys.executable, '-c', CODE, '--ros-args', *arguments],
            stdout=file, stderr=subprocess.STDOUT, env=os.environ)


def joint_state(names, stamp_ns, position, velocity=()):
    """Return a message."""
    message = JointState(name=list(names), position=list(map(float, position)),
                         velocity=list(map(float, velocity)))
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    return message


def wrench_stamped(stamp_ns, values, frame):
    """Return a message with force and torque."""
    message = WrenchStamped()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    message.header.frame_id = frame
    force, torque = message.wrench.force, message.wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = map(float, values)
    return message


def smooth_motion(n_joints, t):
    """Return positions and velocities of joints at a time [s]."""
    k = np.arange(1, n_joints + 1)
    a, w = 0.1 + 0.03 * k, 0.5 + 0.3 * k
    return 0.2 + a * np.sin(w * t), a * w * np.cos(w * t)


def stamp_ns(message):
    """Return the stamp of a message."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def six(value):
    """Return a Twist or Accel, angular first."""
    return np.array([value.angular.x, value.angular.y, value.angular.z,
                     value.linear.x, value.linear.y, value.linear.z])


PUMA = 'package://screw_kinematics/config/robots/puma560.yaml'
PANDA = 'package://screw_kinematics/config/robots/panda.yaml'
RPR = 'package://screw_kinematics/config/robots/rpr.yaml'

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Bags for tests: written by rosbags alone, of a motion that is known exactly."""
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip('rosbags')

from rosbags.rosbag1 import Writer as Ros1Writer    # noqa: E402
from rosbags.rosbag2 import Reader, StoragePlugin, Writer    # noqa: E402
from rosbags.typesys import get_typestore, Stores    # noqa: E402

from screw_kinematics import models    # noqa: E402
from screw_kinematics.tools import robot_options    # noqa: E402

TYPES = get_typestore(Stores.ROS2_JAZZY)
ROS1 = get_typestore(Stores.ROS1_NOETIC)
START = 1_700_000_000_123_456_789
JOINT_STATE = 'sensor_msgs/msg/JointState'
ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
PUMA = models.load(ROBOTS / 'puma560.yaml')
MOTION = robot_options.motion(PUMA, 'multisine')
QUANTUM = 1e-5


def header(stamp, frame=''):
    """Return a header message."""
    time = TYPES.types['builtin_interfaces/msg/Time'](*divmod(stamp, 1_000_000_000))
    return TYPES.types['std_msgs/msg/Header'](time, frame)


def joint_state(stamp, names, position, velocity=()):
    """Return a serialized JointState."""
    message = TYPES.types[JOINT_STATE](
        header(stamp), list(names), np.array(position, float), np.array(velocity, float),
        np.zeros(0))
    return bytes(TYPES.serialize_cdr(message, JOINT_STATE))


def samples(count, rate=200.0, joints=slice(None), offset=0, topic='/joint_states',
            velocity=True):
    """Yield topic, type, time of reception and bytes of the PUMA's joint states."""
    since = offset + np.rint(np.arange(count) / rate * 1e9).astype(np.int64)
    positions, velocities = MOTION.derivatives(since * 1e-9, 1)
    positions = np.round(positions / QUANTUM) * QUANTUM
    for stamp, q, qd in zip((START + since).tolist(), positions, velocities):
        yield (topic, JOINT_STATE, stamp + 300_000,
               joint_state(stamp, PUMA.joint_names[joints], q[joints],
                           qd[joints] if velocity else ()))


def write_bag(path, messages, storage='mcap'):
    """Write a bag; return its path."""
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()]) as writer:
        connections = {}
        for topic, kind, received, data in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=TYPES)
            writer.write(connections[topic], received, data)
    return path


def write_ros1_bag(path, count, compression=None):
    """Write a bag of ROS 1 with the PUMA's joint states; return its path."""
    kind = ROS1.types[JOINT_STATE]
    header, time = ROS1.types['std_msgs/msg/Header'], ROS1.types['builtin_interfaces/msg/Time']
    writer = Ros1Writer(path)
    if compression:
        writer.set_compression(Ros1Writer.CompressionFormat[compression])
    with writer:
        connection = writer.add_connection('/joint_states', JOINT_STATE, typestore=ROS1)
        for k, (_, _, received, data) in enumerate(samples(count)):
            sample = TYPES.deserialize_cdr(data, JOINT_STATE)
            stamp = sample.header.stamp
            message = kind(header(k, time(stamp.sec, stamp.nanosec), ''), sample.name,
                           sample.position, sample.velocity, sample.effort)
            writer.write(connection, received, bytes(ROS1.serialize_ros1(message, JOINT_STATE)))
    return path


def read_bag(path):
    """Return the messages of a bag by topic, as (time of reception, message)."""
    found = {}
    with Reader(path) as reader:
        for connection, received, data in reader.messages():
            found.setdefault(connection.topic, []).append(
                (received, TYPES.deserialize_cdr(data, connection.msgtype)))
    return found


def stamp_of(message):
    """Return the stamp of a message [ns]."""
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def six(part):
    """Return a Twist or Accel as an array, angular first."""
    return np.array([part.angular.x, part.angular.y, part.angular.z,
                     part.linear.x, part.linear.y, part.linear.z])


def exact(stamps, order=2):
    """Return the exact state of the PUMA at stamps [ns]."""
    return PUMA.state(*MOTION.derivatives((np.array(stamps) - START) * 1e-9, order))


def relative_error(found, expected, margin=40):
    """Return the RMS error as a fraction of the RMS of the truth, off both ends."""
    found, expected = np.array(found)[margin:-margin], expected[margin:-margin]
    return np.sqrt(((found - expected)**2).mean() / (expected**2).mean())

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What is listened to, by rules that are the same for every kind of topic."""
from geometry_msgs.msg import TwistStamped, WrenchStamped
from nav_msgs.msg import Odometry
import pytest
import rclpy
from rclpy.serialization import serialize_message
from screw_kinematics.errors import Reason
from screw_kinematics.node.topic_inputs import BaseInput, JointInput, WrenchInput
from sensor_msgs.msg import JointState

KINDS = [(JointInput, JointState), (WrenchInput, WrenchStamped), (BaseInput, Odometry),
         (BaseInput, TwistStamped)]


@pytest.fixture
def node(context):
    made = rclpy.create_node('listener', context=context)
    yield made
    made.destroy_node()


@pytest.fixture(params=KINDS)
def opened(request, node, wait_until):
    """Give an input that has found its publisher, where it must, and the type it reads."""
    kind, message_type = request.param
    made = kind(node, '/topic', [])
    node.create_publisher(message_type, '/topic', 10)
    made.open()
    if kind is BaseInput:
        wait_until(lambda: made.look() or made.type is not None)
    return made, message_type


def test_stamps_are_judged_alike(node, opened, monkeypatch):
    made, message_type = opened
    handed_on = []
    monkeypatch.setattr(made, '_hand_on', lambda sample: handed_on.append(sample.stamp_ns))
    message = message_type()
    before = node.get_clock().now().nanoseconds
    for seconds in (-1, 0, 7):
        message.header.stamp.sec = seconds
        made.receive(serialize_message(message))
    made.receive(b'\0\1\0\0')
    assert (made.received, made.unstamped) == (4, 1)
    assert made.refused == {Reason.STAMP_NEGATIVE: 1, Reason.MALFORMED: 1}
    present, given = handed_on
    assert before <= present <= node.get_clock().now().nanoseconds and given == 7 * 10**9


def test_a_closed_input_has_no_subscription(node, opened):
    made, message_type = opened
    # Wrenches are listened to while somebody wants what is made of them; nobody does here.
    assert made.type is (None if isinstance(made, WrenchInput) else message_type)
    assert not made.look() and made.problem == ''
    made.close()
    assert made.type is None and not made.look()
    assert '/topic' not in [s.topic_name for s in node.subscriptions]

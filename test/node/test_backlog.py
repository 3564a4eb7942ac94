# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages that wait for each other are worked through together, and lead to the same outputs."""
from geometry_msgs.msg import AccelStamped, TwistStamped
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from screw_kinematics.errors import Reason
from screw_kinematics.node import topic_inputs
from screw_kinematics.node.parameters import NodeParameters
from screw_kinematics.node.robot import Robot
from screw_kinematics.node.worker import Worker
from sensor_msgs.msg import JointState
from support.rig import joint_state, PUMA, smooth_motion

COUNT = 60
KEEP = QoSProfile(depth=1000)
JOINTS = [f'q{k}' for k in range(1, 7)]
ROBOTS = ['left', 'right']


def message(k):
    """Return the message of a millisecond; each has a stamp of its own, which is its number."""
    return serialize_message(joint_state(
        JOINTS, 10**9 + k * 10**6, *smooth_motion(len(JOINTS), k * 1e-3)))


class Bed:
    """A topic of two robots, driven by hand, and who listens to their outputs."""

    def __init__(self, context, executor, namespace, **settings):
        self.node = rclpy.create_node('backlog', context=context, namespace=namespace)
        self.executor = executor(context=context)
        self.executor.add_node(self.node)
        parameters, self.worker = NodeParameters(self.node), Worker()
        self.robots, self.outputs = [], {}
        for name in ROBOTS:
            parameters.declare_robot(name)
            self.robots.append(Robot(self.node, parameters.robot_settings(name, {
                f'{name}.{key}': value for key, value in {
                    'description': PUMA, 'joint_states_topic': ['joints'], **settings}.items()}),
                self.worker))
            for output, kind in ('twist', TwistStamped), ('accel', AccelStamped):
                self.listen(f'{name}/{output}', kind)
        self.input = topic_inputs.JointInput(
            self.node, self.node.resolve_topic_name('joints'), self.robots)
        self.publisher = self.node.create_publisher(JointState, 'joints', KEEP)

    def listen(self, topic, kind):
        """Collect the bytes of a topic."""
        self.outputs[topic] = []
        self.node.create_subscription(kind, topic, self.outputs[topic].append, KEEP, raw=True)

    def begin(self, wait_until):
        """Open the input, once all outputs are made."""
        def serving():
            for robot in self.robots:
                robot.update_demand(0.0)
            self.worker.collect()
            return not self.worker.pending and all(
                len(robot.publishers.wanted) == 2 for robot in self.robots)
        for robot in self.robots:
            robot.load_from_parameter()
        wait_until(serving)
        self.input.open()
        wait_until(lambda: self.publisher.get_subscription_count() == 1)

    def work(self, wait_until, received):
        """Work until so many messages were received and each output came that is due."""
        wait_until(lambda: self.input.received >= received and all(
            len(outputs) == robot.account.outputs for robot in self.robots
            for topic, outputs in self.outputs.items() if topic.startswith(robot.name)),
            poll=lambda: self.executor.spin_once(0.05))

    def close(self):
        """End all."""
        self.executor.shutdown()
        self.worker.close()
        self.node.destroy_node()


@pytest.fixture(params=[EventsExecutor, SingleThreadedExecutor])
def make_bed(request, context):
    """Give a function that makes beds."""
    made = []

    def make(**settings):
        made.append(Bed(context, request.param, f'bed{len(made)}', **settings))
        return made[-1]
    yield make
    for bed in made:
        bed.close()


def publish(bed, numbers, malformed=()):
    """Publish messages by number, bytes that are no joint state in place of some."""
    for k in numbers:
        # Plain CDR that says that there are far more names than bytes.
        bed.publisher.publish(
            message(k)[:12] + b'\xff' * 8 if k in malformed else message(k))


def test_a_backlog_leads_to_what_single_messages_lead_to(make_bed, wait_until):
    one_by_one, at_once = make_bed(), make_bed()
    one_by_one.begin(wait_until)
    for k in range(COUNT):
        publish(one_by_one, [k])
        one_by_one.work(wait_until, k + 1)
    at_once.begin(wait_until)
    publish(at_once, range(COUNT))
    at_once.work(wait_until, COUNT)
    for bed in one_by_one, at_once:
        assert bed.input.received == COUNT
        assert all(len(outputs) > COUNT // 2 for outputs in bed.outputs.values())
    assert at_once.outputs == one_by_one.outputs
    for a, b in zip(one_by_one.robots, at_once.robots):
        assert vars(a.account) == vars(b.account)


def test_what_is_wrong_with_one_message_does_not_reach_the_others(
        make_bed, wait_until, monkeypatch):
    bed = make_bed(velocity_source='measured', outputs=['twist', 'accel'])
    bed.begin(wait_until)
    faulty, good = bed.robots
    take, publish_state = faulty.pipeline.take, good.publishers.publish

    def fail_at_20(sample):
        if sample.stamp_ns == 10**9 + 20 * 10**6:
            raise TypeError('a defect of one robot')
        return take(sample)

    def fail_at_30(state):
        if state.stamp_ns == 10**9 + 30 * 10**6:
            raise TypeError('a defect of one publisher')
        publish_state(state)
    monkeypatch.setattr(faulty.pipeline, 'take', fail_at_20)
    monkeypatch.setattr(good.publishers, 'publish', fail_at_30)
    publish(bed, range(COUNT), malformed={10})
    wait_until(lambda: bed.input.received == COUNT
               and len(bed.outputs['left/twist']) == faulty.account.outputs
               and len(bed.outputs['right/twist']) == good.account.outputs - 1,
               poll=lambda: bed.executor.spin_once(0.05))
    assert bed.input.refused == {Reason.MALFORMED: 1}
    assert (faulty.account.received, good.account.received) == (COUNT - 1, COUNT - 1)
    assert faulty.account.refused == {Reason.INTERNAL_ERROR: 1}
    assert (faulty.account.outputs, good.account.outputs) == (COUNT - 2, COUNT - 1)


@pytest.mark.parametrize('settings, together', [
    ({}, True),
    # What is measured beside comes in the order in which it was sent.
    ({'joint_states_topic': ['joints', 'gripper']}, False),
    ({'base_motion_topic': 'odom'}, False)])
def test_waiting_messages_of_one_stream_are_published_together(
        make_bed, wait_until, monkeypatch, settings, together):
    bed = make_bed(velocity_source='measured', outputs=['twist', 'accel'], **settings)
    bed.begin(wait_until)
    monkeypatch.setattr(topic_inputs, 'LONGEST', 60.0)      # this process may stand still
    taken, published = [], []
    take, publish_all = bed.input._take, bed.robots[0].publish
    monkeypatch.setattr(bed.input, '_take', lambda data: (taken.append(1), take(data)))
    monkeypatch.setattr(bed.robots[0], 'publish', lambda: (
        published.append(len(taken)), publish_all()))
    publish(bed, range(COUNT))
    wait_until(lambda: bed.input.received == COUNT, poll=lambda: bed.executor.spin_once(0.05))
    assert published[-1] == COUNT
    if together:
        assert len(published) < COUNT
    else:
        assert published == list(range(1, COUNT + 1))

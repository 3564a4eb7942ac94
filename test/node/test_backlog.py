# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages that wait are worked through together, and lead to the same outputs."""
from geometry_msgs.msg import AccelStamped, TwistStamped
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from screw_kinematics.errors import Reason
from screw_kinematics.node import backlog
from screw_kinematics.node.parameters import NodeParameters
from screw_kinematics.node.robot import Robot
from screw_kinematics.node.topic_inputs import JointInput
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
    """Two robots, driven by hand, of one topic or of two, and who listens to their outputs."""

    def __init__(self, context, executor, namespace, topics=('joints', 'joints'), **settings):
        self.node = rclpy.create_node('backlog', context=context, namespace=namespace)
        self.executor = executor(context=context)
        self.executor.add_node(self.node)
        parameters, self.worker = NodeParameters(self.node), Worker()
        self.robots, self.outputs, shared = [], {}, backlog.Backlog()
        for name, topic in zip(ROBOTS, topics):
            parameters.declare_robot(name)
            self.robots.append(Robot(self.node, parameters.robot_settings(name, {
                f'{name}.{key}': value for key, value in {
                    'description': PUMA, 'joint_states_topic': [topic], **settings}.items()}),
                self.worker))
            for output, kind in ('twist', TwistStamped), ('accel', AccelStamped):
                self.listen(f'{name}/{output}', kind)
        self.inputs = [JointInput(
            self.node, self.node.resolve_topic_name(topic),
            [robot for robot, of in zip(self.robots, topics) if of == topic], shared)
            for topic in dict.fromkeys(topics)]
        self.publishers = [self.node.create_publisher(JointState, each.topic, KEEP)
                           for each in self.inputs]

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
        for each in self.inputs:
            each.open()
        wait_until(lambda: all(each.get_subscription_count() == 1 for each in self.publishers))

    def work(self, wait_until, received):
        """Work until so many messages were received and each output came that is due."""
        wait_until(lambda: min(each.received for each in self.inputs) >= received and all(
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
        for publisher in bed.publishers:
            publisher.publish(message(k)[:12] + b'\xff' * 8 if k in malformed else message(k))


@pytest.mark.parametrize('topics', [('joints', 'joints'), ('left', 'right')])
def test_a_backlog_leads_to_what_single_messages_lead_to(make_bed, wait_until, topics):
    one_by_one, at_once = make_bed(topics=topics), make_bed(topics=topics)
    one_by_one.begin(wait_until)
    for k in range(COUNT):
        publish(one_by_one, [k])
        one_by_one.work(wait_until, k + 1)
    at_once.begin(wait_until)
    publish(at_once, range(COUNT))
    at_once.work(wait_until, COUNT)
    for bed in one_by_one, at_once:
        assert [each.received for each in bed.inputs] == [COUNT] * len(bed.inputs)
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
    of_both, = bed.inputs
    wait_until(lambda: of_both.received == COUNT
               and len(bed.outputs['left/twist']) == faulty.account.outputs
               and len(bed.outputs['right/twist']) == good.account.outputs - 1,
               poll=lambda: bed.executor.spin_once(0.05))
    assert of_both.refused == {Reason.MALFORMED: 1}
    assert (faulty.account.received, good.account.received) == (COUNT - 1, COUNT - 1)
    assert faulty.account.refused == {Reason.INTERNAL_ERROR: 1}
    assert (faulty.account.outputs, good.account.outputs) == (COUNT - 2, COUNT - 1)


@pytest.mark.parametrize('topics', [('joints', 'joints'), ('left', 'right')])
@pytest.mark.parametrize('settings, together', [
    ({}, True),
    # What is measured beside comes in the order in which it was sent.
    ({'joint_states_topic': ['joints', 'gripper']}, False),
    ({'base_motion_topic': 'odom'}, False)])
def test_waiting_messages_of_single_streams_are_published_together(
        make_bed, wait_until, monkeypatch, topics, settings, together):
    bed = make_bed(topics=topics, velocity_source='measured', **settings)
    bed.begin(wait_until)
    monkeypatch.setattr(backlog, 'LONGEST', 60.0)       # this process may stand still
    taken, published = 0, []
    for each in bed.inputs:
        def counted(data, take=each._take):
            nonlocal taken
            taken += 1
            take(data)
        monkeypatch.setattr(each, '_take', counted)
    for robot in bed.robots:
        def noted(publish_all=robot.publish):
            if taken not in published:
                published.append(taken)
            publish_all()
        monkeypatch.setattr(robot, 'publish', noted)
    publish(bed, range(COUNT))
    count = COUNT * len(bed.inputs)
    wait_until(lambda: taken == count and published[-1] == count,
               poll=lambda: bed.executor.spin_once(0.05))
    if together:
        # No more of a topic than a usual listener's queue holds.
        steps = [after - before for before, after in zip([0, *published], published)]
        assert max(steps) <= backlog.MOST * len(bed.inputs) and len(steps) < COUNT
    else:
        assert published == list(range(1, count + 1))

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The robots of a recording: their models, and the topics their joints come on."""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from .blocks import Smoothing
from .recording import Message, Recording
from .robot_states import RobotStates, StateBlock
from .stage_times import StageTimes
from ..errors import MalformedMessageError, ToolError
from ..messages.joint_state import JointSample, JointStateDecoder
from ..pipeline.robot_model import build_model
from ..pipeline.settings import RobotSettings

JOINT_STATE = 'sensor_msgs/msg/JointState'
_STRING = 'std_msgs/msg/String'


class RecordedRobot:
    """
    A robot and its topics in a recording.

    Parameters
    ----------
    states : RobotStates
        What is made of its samples.
    topics : sequence of str
        Full names of its topics of joint states.
    stages : StageTimes
        Gets the time spent.

    """

    def __init__(self, states: RobotStates, topics: Sequence[str], stages: StageTimes) -> None:
        self.states = states
        self.topics = tuple(topics)
        self._decode = JointStateDecoder().decode
        self._stages = stages

    def take(self, messages: Iterable[Message]) -> Iterator[StateBlock]:
        """Take recorded messages, of any topic; yield states."""
        with self._stages.stage('decode'):
            samples = list(self._samples(messages))
        yield from self.states.add(samples)

    def _samples(self, messages: Iterable[Message]) -> Iterator[tuple[int, JointSample]]:
        for message in messages:
            if message.topic in self.topics and message.kind == JOINT_STATE:
                try:
                    yield message.received, self._decode(message.data)
                except MalformedMessageError:
                    self.states.account.received += 1
                    self.states.account.refused['malformed_message'] += 1


def recorded_robots(recording: Recording, settings: Sequence[RobotSettings], namespace: str,
                    smoothing: Smoothing, stages: StageTimes) -> list[RecordedRobot]:
    """
    Return the robots with their models.

    Parameters
    ----------
    recording : Recording
        May hold robot descriptions.
    settings : sequence of RobotSettings
        As the node has them.
    namespace : str
        Of the node.
    smoothing : Smoothing
        Where joint samples are smoothed.
    stages : StageTimes
        Gets the time spent.

    Raises
    ------
    ModelError, ToolError
        A model is not readable; a description or a topic is not in the recording.

    """
    robots = []
    for robot in settings:
        topics = [full_name(namespace, topic) for topic in robot.joint_states_topic]
        there = sorted(name for name, kind in recording.topics.items() if kind == JOINT_STATE)
        for topic in topics:
            if recording.topics and topic not in there:
                raise ToolError(f'{recording.path}: no joint states on {topic}; topics of that '
                                f'type: {", ".join(there) or "none"}')
        text = None
        if not robot.description:
            topic = full_name(namespace, robot.description_topic)
            text = description_in(recording, topic)
            if text is None:
                raise ToolError(f'{recording.path}: no robot description on {topic}; name the '
                                "model in the parameter 'description'")
        with stages.stage('models'):
            states = RobotStates(robot, build_model(robot, text), smoothing, stages)
        robots.append(RecordedRobot(states, topics, stages))
    return robots


def full_name(namespace: str, topic: str) -> str:
    """
    Return the full name of a topic.

    Examples
    --------
    >>> full_name('lab', 'joint_states'), full_name('lab', '/joint_states')
    ('/lab/joint_states', '/joint_states')

    """
    if topic.startswith('/'):
        return topic
    return '/'.join(['', *(part for part in (*namespace.split('/'), topic) if part)])


def description_in(recording: Recording, topic: str) -> str | None:
    """Return the last robot description recorded on a topic, if there is one."""
    from rosbags.typesys import get_typestore, Stores
    found = None
    for message in Recording(recording.path).messages({_STRING}):
        if message.topic == topic:
            found = message.data
    if found is None:
        return None
    description: Any = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(found, _STRING)
    return str(description.data)

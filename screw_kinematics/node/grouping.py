# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Which robots share a topic: each is subscribed to once."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

from .robot import Robot
from ..errors import ParameterError


def by_topic(node: Node, robots: Iterable[Robot], parameter: str,
             topics: Callable[[Robot], Sequence[str]]) -> dict[str, list[Robot]]:
    """
    Return the robots that listen to each topic.

    Parameters
    ----------
    node : rclpy.node.Node
        Whose namespace and remappings apply.
    robots : iterable of Robot
        The robots to ask.
    parameter : str
        Name of the parameter that holds the topics, without the robot's.
    topics : callable
        From a robot to its topics.

    Returns
    -------
    dict from str to list of Robot
        By the full name of the topic.

    Raises
    ------
    ParameterError
        A topic has an invalid name.

    """
    listeners: dict[str, list[Robot]] = {}
    for robot in robots:
        for topic in topics(robot):
            try:
                validate_topic_name(topic)
            except InvalidTopicNameException:
                raise ParameterError(f'{robot.name}.{parameter}', topic, 'a topic name') from None
            listeners.setdefault(node.resolve_topic_name(topic), []).append(robot)
    return listeners

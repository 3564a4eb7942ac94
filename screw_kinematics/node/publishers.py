# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of one robot: who listens, and what publishes a state on each."""
from __future__ import annotations

from importlib import import_module
from typing import Any, Protocol

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions

from .markers import MarkerPublisher
from ..pipeline.kinematics import Kinematics, State
from ..pipeline.message_writers import message_writer, MessageWriter
from ..pipeline.outputs import KINDS
from ..pipeline.settings import RobotSettings


class OutputPublisher(Protocol):
    """
    What publishes states on one topic.

    Attributes
    ----------
    order : int
        Highest derivative of the joint positions that it needs.

    """

    order: int

    def publish(self, state: State) -> None:
        """Publish a state."""


class BytesPublisher:
    """
    Publishes messages that are written as bytes.

    By the raw door: `Publisher.publish` asks each time of what kind the message is, and keeps
    other threads from destroying the publisher meanwhile, which takes longer than to publish;
    only the thread that publishes destroys publishers here.
    """

    def __init__(self, publisher: Publisher, writer: MessageWriter, order: int) -> None:
        self.order = order
        self._handle = publisher.handle
        self._writer = writer

    def publish(self, state: State) -> None:
        """Publish a state."""
        self._handle.publish_raw(self._writer.encode(state))


class Publishers:
    """
    The topics of one robot.

    Parameters
    ----------
    node : rclpy.node.Node
        Publishers are created on it.

    Attributes
    ----------
    wanted : tuple of str
        The outputs that somebody listened to when last asked.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers: dict[str, Publisher] = {}
        self._active: dict[str, OutputPublisher] = {}
        self.wanted: tuple[str, ...] = ()

    def advertise(self, settings: RobotSettings) -> None:
        """Have a topic for each output of these settings, and no others."""
        for output in self._publishers.keys() - set(settings.outputs):
            self._active.pop(output, None)
            self._node.destroy_publisher(self._publishers.pop(output))
        for output in settings.outputs:
            if output not in self._publishers:
                self._publishers[output] = self._node.create_publisher(
                    message_type(KINDS[output].type_name), f'{settings.name}/{output}',
                    QoSProfile(depth=10),
                    qos_overriding_options=QoSOverridingOptions.with_default_policies())
        self.wanted = tuple(name for name in self.wanted if name in self._publishers)

    def update_demand(self) -> bool:
        """See who listens; return whether that changed."""
        wanted = tuple(
            name for name in KINDS
            if name in self._publishers and self._publishers[name].get_subscription_count() > 0)
        changed = wanted != self.wanted
        self.wanted = wanted
        return changed

    @property
    def needs(self) -> tuple[str, ...]:
        """Return the outputs of a program that serves what is wanted; none if nothing is."""
        needs = tuple(dict.fromkeys(need for name in self.wanted for need in KINDS[name].needs))
        # Outputs that are of the joints alone go with the smallest program.
        return needs or (('pose',) if self.wanted else ())

    @property
    def order(self) -> int:
        """Return the highest derivative of the joint positions that is wanted."""
        return max((KINDS[name].order for name in self.wanted), default=0)

    @property
    def covariance(self) -> bool:
        """Whether something wanted needs the variances of the joints."""
        return any(KINDS[name].covariance for name in self.wanted)

    def activate(self, kinematics: Kinematics, model: Any, settings: RobotSettings) -> None:
        """
        Publish all that is wanted from now on.

        Parameters
        ----------
        kinematics : Kinematics
            What is computed.
        model : SerialChain or ParallelManipulator
            Names the frames.
        settings : RobotSettings
            Axes and reference point of the program, and prefix of frame names.

        """
        slices = kinematics.program.slices
        self._active = {}
        for name in self.wanted:
            publisher = self._publishers[name]
            if name == 'markers':
                self._active[name] = MarkerPublisher(
                    publisher.publish, slices, settings,
                    settings.frame_prefix + model.base_frame)
            else:
                self._active[name] = BytesPublisher(
                    publisher, message_writer(name, slices, model, settings), KINDS[name].order)

    def deactivate(self) -> None:
        """Publish nothing."""
        self._active = {}

    def publish(self, state: State) -> None:
        """Publish a state on every active topic, as far as it is known."""
        for publisher in self._active.values():
            if publisher.order <= state.order:
                publisher.publish(state)

    def clear_markers(self) -> None:
        """Delete the markers that viewers show of this robot."""
        markers = self._active.get('markers')
        if isinstance(markers, MarkerPublisher):
            markers.clear()

    def close(self) -> None:
        """Remove the topics."""
        self.deactivate()
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        self._publishers.clear()
        self.wanted = ()


def message_type(name: str) -> Any:
    """Return the ROS message type of a name such as ``geometry_msgs/msg/TwistStamped``."""
    package, folder, kind = name.split('/')
    return getattr(import_module(f'{package}.{folder}'), kind)

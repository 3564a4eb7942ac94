# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of one robot: who listens, and the functions that publish."""
from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions

from .markers import MarkerSender
from ..pipeline.outputs import (
    Frames, KINDS, make_send, Send, send_joint_states, Slices, Values, Variances)
from ..pipeline.settings import RobotSettings
from ..screws.body_state import BodyState


class RobotTopics:
    """
    Publishers of one robot, and how values become messages.

    Parameters
    ----------
    node : rclpy.node.Node
        Publishers are created on it.

    Attributes
    ----------
    wanted : tuple of str
        The outputs that somebody listened to when last asked.
    sends : tuple of callable
        Publish the outputs in use, from stamp [ns] and values of the program.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers: dict[str, Publisher] = {}
        self._active: dict[str, Send] = {}
        self._markers: MarkerSender | None = None
        self.wanted: tuple[str, ...] = ()
        self.sends: tuple[Send, ...] = ()

    def offer(self, settings: RobotSettings) -> None:
        """Have a topic for each output of these settings, and no others."""
        for output in self._publishers.keys() - set(settings.outputs):
            self.use_only(self._active.keys() - {output})
            self._node.destroy_publisher(self._publishers.pop(output))
        for output in settings.outputs:
            if output not in self._publishers:
                self._publishers[output] = self._node.create_publisher(
                    KINDS[output].message, f'{settings.name}/{output}', QoSProfile(depth=10),
                    qos_overriding_options=QoSOverridingOptions.with_default_policies())
        self.wanted = tuple(name for name in self.wanted if name in self._publishers)

    def check_demand(self) -> bool:
        """See who listens; return whether that changed."""
        wanted = tuple(
            name for name in KINDS
            if name in self._publishers and self._publishers[name].get_subscription_count() > 0)
        changed = wanted != self.wanted
        self.wanted = wanted
        return changed

    @property
    def needs(self) -> tuple[str, ...]:
        """Return the outputs of a program that serves what is wanted."""
        return tuple(dict.fromkeys(need for name in self.wanted for need in KINDS[name].needs))

    @property
    def needs_variances(self) -> bool:
        """Whether something wanted needs variances."""
        return any(KINDS[name].derivative for name in self.wanted)

    def use(self, slices: Slices, model: Any, settings: RobotSettings,
            variances: Variances) -> None:
        """
        Publish all that is wanted from now on.

        Parameters
        ----------
        slices : dict from str to slice
            Where the program's outputs are among its values.
        model : SerialChain or ParallelManipulator
            Names the frames.
        settings : RobotSettings
            Axes and reference point of the program, and prefix of frame names.
        variances : callable
            From a derivative to the variance of each joint.

        """
        prefix = settings.frame_prefix
        base, tip = prefix + model.base_frame, prefix + model.tip_frame
        frames = Frames(base, tip, tip if settings.expressed_in == 'tip' else base)
        self._active = {
            name: make_send(name, publish_bytes(self._publishers[name]), slices, frames,
                            variances)
            for name in self.wanted if name not in ('markers', 'passive_joint_states')}
        if 'markers' in self.wanted:
            self._markers = MarkerSender(
                self._publishers['markers'].publish, _state_reader(slices, settings),
                base, settings.markers_rate, settings.stale_timeout)
            self._active['markers'] = self._markers.send
        if 'passive_joint_states' in self.wanted:
            self._active['passive_joint_states'] = send_joint_states(
                self._publishers['passive_joint_states'].publish, slices,
                model.passive_joint_names)
        self.sends = tuple(self._active.values())

    def use_only(self, outputs: Iterable[str]) -> None:
        """Publish, of what is published now, these only."""
        self._active = {name: send for name, send in self._active.items() if name in outputs}
        self.sends = tuple(self._active.values())
        if 'markers' not in self._active:
            self._markers = None

    def clear_markers(self) -> None:
        """Delete the markers that viewers show of this robot."""
        if self._markers is not None:
            self._markers.clear()

    def close(self) -> None:
        """Remove the topics."""
        self.use_only(())
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        self._publishers.clear()
        self.wanted = ()


def publish_bytes(publisher: Publisher) -> Callable[[bytes], None]:
    """
    Return the function that publishes serialized messages.

    `Publisher.publish` asks each time of what kind the message is, and keeps other threads from
    destroying the publisher meanwhile, which takes longer than to publish; only the thread that
    publishes destroys publishers here.
    """
    publish: Callable[[bytes], None] = publisher.handle.publish_raw
    return publish


def _state_reader(slices: Slices, settings: RobotSettings) -> Any:
    """Return a function from the values of a program to the state they describe."""
    at_pose, at_twist, at_accel = (slices[n] for n in KINDS['markers'].needs)
    axes, pole = settings.expressed_in, settings.reference_point

    def read(values: Values) -> BodyState:
        pose = np.eye(4)
        pose[:3, 3] = values[at_pose][:3]
        pose[:3, :3] = np.reshape(values[at_pose][3:], (3, 3))
        reduced = np.array(values[at_twist]), np.array(values[at_accel])
        return BodyState(pose, reduced, pose[:3, 3] if pole == 'tip' else np.zeros(3),
                         pole=pole, axes=axes)
    return read

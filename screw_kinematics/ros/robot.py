# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One robot of the node: its model, its pipeline, and its topics."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions

from .background import Background
from .outputs import Frames, KINDS, make_send, Send
from .robot_model import build_model, continuous_joints
from .settings import RobotSettings
from ..accounting import Account
from ..errors import ScrewKinematicsError
from ..pipeline import RobotPipeline

NO_MODEL = 'no_model_yet'


class Robot:
    """
    A robot of the node.

    Only what somebody listens to is computed: the program for that set of outputs is
    compiled in the background when the set changes, and used from then on.

    Parameters
    ----------
    node : rclpy.node.Node
        Publishers are created on it.
    settings : RobotSettings
    background : Background

    """

    def __init__(self, node: Node, settings: RobotSettings, background: Background) -> None:
        self._node = node
        self._background = background
        self.settings = settings
        self.account = Account()
        self.model: Any = None
        self.pipeline: RobotPipeline | None = None
        self.model_error = ''
        self.description_text: str | None = None
        self._publishers: dict[str, Publisher] = {}
        self._wanted: frozenset[str] = frozenset()
        self._programs: dict[tuple[str, ...], Any] = {}
        self._active: dict[str, Send] = {}
        self._sends: tuple[Send, ...] = ()
        # Results of background work count only if nothing newer was begun.
        self._latest_load = self._latest_compilation = 0
        self._open_publishers()

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.settings.name

    @property
    def wanted(self) -> list[str]:
        """Return the outputs that somebody listens to."""
        return [name for name in KINDS if name in self._wanted]

    def take(self, stamp_ns: int, names: tuple[str, ...], position: Sequence[float],
             velocity: Sequence[float]) -> None:
        """Take a joint sample, and publish what it leads to."""
        pipeline = self.pipeline
        if pipeline is None:
            self.account.received += 1
            self.account.refused[NO_MODEL] += 1
            return
        values = pipeline.take(stamp_ns, names, position, velocity)
        if values is not None:
            for send in self._sends:
                send(pipeline.stamp_ns, values)

    def load_given(self) -> None:
        """Load the model of the ``description`` parameter; raise ModelError."""
        self.set_model(build_model(self.settings))

    def load_text(self, text: str) -> None:
        """Load a URDF text beside the stream of messages; keep the old model if it fails."""
        self._latest_load += 1
        number, settings = self._latest_load, self.settings

        def done(model: Any) -> None:
            if number == self._latest_load:
                self.description_text = text
                self.set_model(model)
                self._node.get_logger().info(f'{self.name}: {model!r}')

        def failed(error: ScrewKinematicsError) -> None:
            self.model_error = str(error)
            kept = 'the old model stays' if self.model is not None else 'waiting for another one'
            self._node.get_logger().error(f'{self.name}: {error}; {kept}')

        self._background.submit(partial(build_model, settings, text), done, failed)

    def set_model(self, model: Any) -> None:
        """Use this model from now on; joint motion goes on if the joints are the same."""
        same = self.pipeline is not None and self.model is not None and (
            model.joint_names == self.model.joint_names
            and continuous_joints(model) == continuous_joints(self.model))
        self.model = model
        self.model_error = ''
        if not same:
            self._publish_only([])
            self.pipeline = RobotPipeline(
                model.joint_names, self.settings.motion, continuous_joints(model),
                self.settings.stale_timeout, self.account)
        self._programs.clear()
        self._compile()

    def prepare(self, settings: RobotSettings) -> Any:
        """Return the model that these settings ask for; raise ScrewKinematicsError."""
        old = self.settings
        same = (old.base_frame, old.tip_frame, old.tool_offset) == (
            settings.base_frame, settings.tip_frame, settings.tool_offset)
        if same or self.model is None:
            return self.model
        return build_model(settings, self.description_text)

    def apply(self, settings: RobotSettings, model: Any) -> None:
        """Go over to other settings, with the model that :meth:`prepare` returned."""
        old, self.settings = self.settings, settings
        if settings.outputs != old.outputs:
            self._open_publishers()
        if self.pipeline is None:
            return
        self.pipeline.configure(settings.motion, settings.stale_timeout)
        if model is not self.model:
            self.set_model(model)
        elif settings != old:
            self._programs.clear()
            self._compile()

    def check_demand(self) -> None:
        """See who listens, and compute what they want from now on."""
        wanted = frozenset(name for name, publisher in self._publishers.items()
                           if publisher.get_subscription_count() > 0)
        if wanted != self._wanted:
            self._wanted = wanted
            self._compile()

    def reset(self) -> None:
        """Forget the samples so far, as after a jump of the clock."""
        if self.pipeline is not None:
            self.pipeline.reset()

    def release_silent(self, now: float) -> None:
        """Forget joints that come no more; see :meth:`RobotPipeline.release_silent`."""
        if self.pipeline is not None:
            self.pipeline.release_silent(now, self.settings.stale_timeout)

    def close(self) -> None:
        """Remove the topics."""
        self._latest_load += 1
        self._latest_compilation += 1
        self._publish_only([])
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        self._publishers.clear()

    def _open_publishers(self) -> None:
        for output in list(self._publishers):
            if output not in self.settings.outputs:
                self._node.destroy_publisher(self._publishers.pop(output))
        for output in self.settings.outputs:
            if output not in self._publishers:
                self._publishers[output] = self._node.create_publisher(
                    KINDS[output].message, f'{self.name}/{output}', QoSProfile(depth=10),
                    qos_overriding_options=QoSOverridingOptions.with_default_policies())
        self._wanted &= self._publishers.keys()
        self._publish_only(self._publishers)

    def _publish_only(self, outputs: Iterable[str]) -> None:
        self._active = {name: send for name, send in self._active.items() if name in outputs}
        self._sends = tuple(self._active.values())

    def _compile(self) -> None:
        """Use the program for what is wanted now; make it first if there is none yet."""
        if self.model is None:
            return
        needs = tuple(dict.fromkeys(
            need for name in KINDS if name in self._wanted for need in KINDS[name].needs))
        self._latest_compilation += 1
        number = self._latest_compilation
        if not needs or needs in self._programs:
            self._use(needs)
            return
        work = partial(self.model.compile, needs, axes=self.settings.expressed_in,
                       pole=self.settings.reference_point)

        def done(program: Any) -> None:
            if number == self._latest_compilation:
                self._programs[needs] = program
                self._use(needs)

        def failed(error: ScrewKinematicsError) -> None:
            self._node.get_logger().error(f'{self.name}: {error}')

        self._background.submit(work, done, failed)

    def _use(self, needs: tuple[str, ...]) -> None:
        assert self.pipeline is not None
        if not needs:
            self._publish_only([])
            self.pipeline.want(None)
            return
        program = self._programs[needs]
        prefix = self.settings.frame_prefix
        base, tip = prefix + self.model.base_frame, prefix + self.model.tip_frame
        frames = Frames(base, tip, tip if self.settings.expressed_in == 'tip' else base)
        covariance = any(KINDS[name].derivative for name in self._wanted)
        self.pipeline.want(program, covariance=covariance)
        self._active = {
            name: make_send(name, self._publishers[name].publish, program.slices, frames,
                            self.pipeline.variances)
            for name in KINDS if name in self._wanted}
        self._sends = tuple(self._active.values())

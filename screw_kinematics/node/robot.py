# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One robot of the node: its model, its pipeline, and its topics."""
from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from rclpy.node import Node

from .publishers import RobotTopics
from .worker import Background
from ..errors import ModelError, ScrewKinematicsError
from ..pipeline.account import Account
from ..pipeline.robot_model import build_model, check_outputs, continuous_joints
from ..pipeline.robot_pipeline import RobotPipeline
from ..pipeline.settings import RobotSettings

NO_MODEL = 'no_model_yet'
INTERNAL_ERROR = 'internal_error'


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
        self._log = node.get_logger()
        self._background = background
        self.settings = settings
        self.account = Account()
        self.model: Any = None
        self.model_error = ''
        self.pipeline: RobotPipeline | None = None
        self.topics = RobotTopics(node)
        self.topics.offer(settings)
        self._description: str | None = None
        self._programs: dict[tuple[str, ...], Any] = {}
        self._last_program: Any = None
        # Results of background work count only if nothing newer was begun.
        self._latest_load = self._latest_compilation = 0

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.settings.name

    def take(self, stamp_ns: int, names: tuple[str, ...], position: Sequence[float],
             velocity: Sequence[float]) -> None:
        """Take a joint sample, and publish what it leads to."""
        pipeline = self.pipeline
        if pipeline is None:
            self.account.received += 1
            self.account.refused[NO_MODEL] += 1
            return
        values = None
        try:
            values = pipeline.take(stamp_ns, names, position, velocity)
            if values is not None:
                for send in self.topics.sends:
                    send(pipeline.stamp_ns, values)
        except Exception as error:      # a fault of one robot must not end the others
            if values is None:
                self.account.refused[INTERNAL_ERROR] += 1
            pipeline.last_error = repr(error)
            pipeline.reset()            # what was half done is not to be built on
            self._log.error(f'{self.name}: {error!r}', throttle_duration_sec=5.0)

    def load_given(self) -> None:
        """Load the model of the ``description`` parameter; raise ScrewKinematicsError."""
        try:
            model = build_model(self.settings)
        except ModelError as error:     # of several robots with one description, whose?
            raise ModelError(f'robot {self.name!r}', error.args[0]) from None
        self._set_model(model)

    def load_text(self, text: str) -> None:
        """Load a URDF text beside the stream of messages; keep the old model if it fails."""
        self._latest_load += 1
        number, settings = self._latest_load, self.settings

        def done(model: Any) -> None:
            if number != self._latest_load:
                return
            if settings is not self.settings:   # they have changed meanwhile
                self.load_text(text)
            else:
                self._description = text
                self._set_model(model)
                self._log.info(f'{self.name}: {model!r}')

        def failed(error: ScrewKinematicsError) -> None:
            self.model_error = str(error)
            kept = 'the old model stays' if self.model is not None else 'waiting for another one'
            self._log.error(f'{self.name}: {error}; {kept}')

        self._background.submit(partial(build_model, settings, text), done, failed)

    def prepare(self, settings: RobotSettings) -> Any:
        """Return the model that these settings ask for; raise ScrewKinematicsError."""
        old = self.settings
        same = (old.base_frame, old.tip_frame, old.tool_offset) == (
            settings.base_frame, settings.tip_frame, settings.tool_offset)
        if self.model is None:
            return None
        if same:
            check_outputs(settings, self.model)
            return self.model
        return build_model(settings, self._description)

    def apply(self, settings: RobotSettings, model: Any) -> None:
        """Go over to other settings, with the model that :meth:`prepare` returned."""
        old, self.settings = self.settings, settings
        self.topics.offer(settings)
        if self.pipeline is None:
            return
        if model is not self.model:
            self._set_model(model)
        elif settings != old:
            self._programs.clear()
            self._compile()

    def look_around(self, now: float) -> None:
        """
        See who listens, and which joints come no more.

        Parameters
        ----------
        now : float
            Time by the node's clock, which may stand still [s].

        """
        if self.topics.check_demand():
            self._compile()
        if self.pipeline is not None and self.pipeline.release_silent(
                now, self.settings.stale_timeout):
            self.topics.clear_markers()

    def posture_report(self) -> dict[str, Any]:
        """Return what the program in use says about the robot's last posture, if anything."""
        report = getattr(self._programs.get(self.topics.needs), 'report', dict)
        return dict(report())

    def reset(self) -> None:
        """Forget the samples so far, as after a jump of the clock."""
        self.topics.clear_markers()
        if self.pipeline is not None:
            self.pipeline.reset()

    def close(self) -> None:
        """Remove the topics."""
        self._latest_load += 1
        self._latest_compilation += 1
        self.topics.close()

    def _set_model(self, model: Any) -> None:
        """Use this model from now on; joint motion goes on if the joints are the same."""
        same = self.model is not None and (
            model.joint_names == self.model.joint_names
            and continuous_joints(model) == continuous_joints(self.model))
        self.model = model
        self.model_error = ''
        for warning in model.warnings:
            self._log.warning(f'{self.name}: {warning}')
        if not same:
            self.topics.use_only(())
            self.pipeline = RobotPipeline(
                model.joint_names, self.settings.motion, continuous_joints(model),
                self.settings.stale_timeout, self.account)
        self._programs.clear()
        self._compile()

    def _compile(self) -> None:
        """Use the program for what is wanted now; make it first if there is none yet."""
        if self.model is None:
            return
        self._latest_compilation += 1
        number, needs = self._latest_compilation, self.topics.needs
        if not needs or needs in self._programs:
            self._use(needs)
            return

        model, settings = self.model, self.settings

        def make() -> Any:
            return model.compile(needs, axes=settings.expressed_in,
                                 pole=settings.reference_point)

        def done(program: Any) -> None:
            if number == self._latest_compilation:
                self._programs[needs] = program
                self._use(needs)

        def failed(error: ScrewKinematicsError) -> None:
            self._log.error(f'{self.name}: {error}')

        self._background.submit(make, done, failed)

    def _use(self, needs: tuple[str, ...]) -> None:
        assert self.pipeline is not None
        self.pipeline.configure(self.settings.motion, self.settings.stale_timeout)
        if not needs:
            self.topics.use_only(())
            self.pipeline.want(None)
            return
        program = self._programs[needs]
        if self._last_program is not None:      # postures of parallel robots go on
            program.continue_from(self._last_program)
        self._last_program = program
        self.pipeline.want(program, covariance=self.topics.needs_variances)
        self.topics.use(program.slices, self.model, self.settings, self.pipeline.variances)

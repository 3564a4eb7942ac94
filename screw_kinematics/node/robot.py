# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One robot of the node: its model, its pipeline, and its topics."""
from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.node import Node

from .publishers import Publishers, Topic
from .worker import Worker
from ..errors import ModelError, Reason, ScrewKinematicsError
from ..messages.base_motion import BaseSample
from ..messages.joint_state import JointSample
from ..messages.wrench import WrenchSample
from ..pipeline.account import Account
from ..pipeline.kinematics import Kinematics, State
from ..pipeline.moving_base import BaseFrames, MovingBase
from ..pipeline.robot_model import (
    build_model, check_outputs, continuous_joints, plausible_velocities)
from ..pipeline.robot_pipeline import RobotPipeline
from ..pipeline.robot_program import compile_robot, Needs, RobotProgram
from ..pipeline.settings import RobotSettings


class Robot:
    """
    A robot of the node, on which its publishers are created.

    Only what somebody listens to is computed: the program for that set of outputs is
    compiled beside the messages when the set changes, and used from then on.
    """

    def __init__(self, node: Node, settings: RobotSettings, worker: Worker) -> None:
        self._log = node.get_logger()
        self._worker = worker
        self.settings = settings
        self.account = Account()
        self.model: Any = None
        self.model_error = ''
        self.pipeline: RobotPipeline | None = None
        self.publishers = Publishers(node)
        self.publishers.advertise(settings)
        self.stamp_ns = 0       # of the latest state [ns]; 0 before the first
        self._states: list[State] = []
        self._description: str | None = None
        self._programs: dict[Needs, RobotProgram] = {}
        self._program: RobotProgram | None = None
        self._base_of: tuple[Any, str, bool] | None = None

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.settings.name

    @property
    def at_work(self) -> str:
        """Return what is made for it beside the messages, in words; empty if nothing."""
        return ('reading its description' if self._worker.is_at((self, 'model')) else
                'compiling its outputs' if self._worker.is_at((self, 'program')) else '')

    def take(self, sample: JointSample) -> None:
        """Take a joint sample; what it leads to is published by :meth:`publish`."""
        pipeline = self.pipeline
        if pipeline is None:
            self.account.close(Reason.NO_MODEL)
            return
        try:
            state = pipeline.take(sample)
        except Exception as error:      # a fault of one robot must not end the others
            self.account.close(Reason.INTERNAL_ERROR, repr(error))
            self._begin_anew(error)
            return
        if isinstance(state, State):
            self._states.append(state)

    def publish(self) -> None:
        """Publish the states of the samples that came since the last call."""
        if not self._states:
            return
        states, self._states = self._states, []
        for state in states:
            try:
                self.publishers.publish(state)
                self.stamp_ns = state.stamp_ns
            except Exception as error:      # nor one message the others
                self._begin_anew(error)

    def _begin_anew(self, error: Exception) -> None:
        """Tell a fault; what is half done is not to be built on."""
        if self.pipeline is not None:
            self.pipeline.reset()
        self._log.error(f'{self.name}: {error!r}', throttle_duration_sec=5.0)

    @property
    def has_one_stream(self) -> bool:
        """
        Whether its states come of one topic alone.

        Else what they are depends on how the messages of several topics follow each other.
        """
        return len(self.settings.joint_states_topic) == 1 and not self.settings.on_moving_base

    def wants_wrench(self, tip: int) -> bool:
        """Return whether somebody listens to the compensated wrench of a tip."""
        return Topic(tip, 'compensated_wrench') in self.publishers.wanted

    def take_wrench(self, tip: int, sample: WrenchSample) -> None:
        """Take what the force sensor of a tip says, and publish what can be told with it."""
        try:
            self.publishers.take_wrench(tip, sample)
        except Exception as error:      # a fault of one robot must not end the others
            self.publishers.forget_wrenches()
            self._log.error(f'{self.name}: {error!r}', throttle_duration_sec=5.0)

    def take_base(self, sample: BaseSample) -> None:
        """Take a sample of the motion of the robot's base."""
        base = None if self.pipeline is None else self.pipeline.base
        if base is None:        # no model yet
            return
        before = base.world
        try:
            base.take(sample)
        except Exception as error:      # a fault of one robot must not end the others
            base.account.close(Reason.INTERNAL_ERROR, repr(error))
            base.reset()
            self._log.error(f'{self.name}: {error!r}', throttle_duration_sec=5.0)
        if base.world != before and self._program is not None and self.publishers.active:
            # Messages name the frame that the base moves in.
            self.publishers.activate(self._program, self.model, self.settings, base.world)

    def join(self, node: Node) -> None:
        """Go over to another node, in place of one that was destroyed; motion goes on."""
        self._log = node.get_logger()
        self.publishers.join(node, self.settings)
        self._compile()

    def load_from_parameter(self) -> None:
        """Load the model of the ``description`` parameter; raise ScrewKinematicsError."""
        try:
            model = build_model(self.settings)
        except ModelError as error:     # of several robots with one description, whose?
            raise ModelError(f'robot {self.name!r}', error.args[0]) from None
        self._set_model(model)

    def load_from_topic(self, text: str) -> None:
        """Load a URDF text beside the stream of messages; keep the old model if it fails."""
        settings = self.settings

        def take(use: Callable[[str, Any], None], result: Any) -> None:
            if settings is self.settings:
                use(text, result)
            else:       # they have changed meanwhile
                self.load_from_topic(text)

        self._worker.submit((self, 'model'), partial(build_model, settings, text),
                            partial(take, self._loaded), partial(take, self._not_loaded))

    def _loaded(self, text: str, model: Any) -> None:
        """Use the model of a description."""
        self._description = text
        self._set_model(model)
        self._log.info(f'{self.name}: {model!r}')

    def _not_loaded(self, text: str, error: ScrewKinematicsError) -> None:
        """Tell what is wrong with a description."""
        self.model_error = str(error)
        kept = 'the old model stays'
        if self.model is None:      # other settings may suit it
            self._description, kept = text, 'waiting for another one, or other parameters'
        self._log.error(f'{self.name}: {error}; {kept}')

    def plan(self, settings: RobotSettings) -> Any:
        """Return the model that these settings ask for; raise ScrewKinematicsError."""
        old = self.settings
        same = [(s.base_frame, s.tip_frame, s.tool_offset) for s in old.parts] == [
            (s.base_frame, s.tip_frame, s.tool_offset) for s in settings.parts]
        if self.model is None:
            return None
        if same:
            check_outputs(settings, self.model)
            return self.model
        return build_model(settings, self._description)

    def carry_out(self, settings: RobotSettings, model: Any) -> None:
        """Go over to other settings, with the model that :meth:`plan` returned."""
        old, self.settings = self.settings, settings
        self.publishers.advertise(settings)
        if self.model is None:
            if self._description is not None and settings != old:
                self.load_from_topic(self._description)
            return
        if model is not self.model:
            self._set_model(model)
        elif settings != old:
            self._programs.clear()
            self._compile()

    def update_demand(self, now: float) -> None:
        """
        See who listens, and which joints come no more.

        The node's clock [s] may stand still.
        """
        if self.publishers.update_demand():
            self._compile()
        if self.pipeline is not None and self.pipeline.release_stale(
                now, self.settings.stale_timeout):
            self.publishers.clear_markers()

    def posture_report(self) -> dict[str, Any]:
        """Return what the program in use says about the robot's last posture, if anything."""
        return {} if self._program is None else self._program.report()

    def reset(self) -> None:
        """Forget the samples so far, as after a jump of the clock."""
        self.publishers.clear_markers()
        self.publishers.forget_wrenches()
        if self.pipeline is not None:
            self.pipeline.reset()

    def close(self) -> None:
        """Remove the topics."""
        for what in ('model', 'program'):
            self._worker.cancel((self, what))
        self.publishers.close()

    def _set_model(self, model: Any) -> None:
        """Use this model from now on; joint motion goes on if the joints are the same."""
        self.model = model
        self.model_error = ''
        for warning in model.warnings:
            self._log.warning(f'{self.name}: {warning}')
        self._programs.clear()
        if self.pipeline is None or (self.pipeline.joint_names, self.pipeline.continuous) != (
                model.joint_names, continuous_joints(model)):
            self.publishers.deactivate()
            self._renew_pipeline()
        self._compile()

    def _renew_pipeline(self) -> RobotPipeline:
        """Return the pipeline that model and settings ask for; the same one if it is that."""
        motion = self.settings.motion
        wanted = (self.model.joint_names, motion, continuous_joints(self.model),
                  plausible_velocities(motion, self.model), self.settings.stale_timeout)
        if self.pipeline is None or self.pipeline.configuration != wanted:
            self.pipeline = RobotPipeline(*wanted, self.account)
            self._base_of = None
        of = (self.model, self.settings.frame_prefix, self.settings.on_moving_base)
        if self._base_of != of:
            self._base_of = of
            self.pipeline.base = MovingBase(
                BaseFrames.of(self.model, self.settings.frame_prefix), motion,
                self.settings.stale_timeout) if self.settings.on_moving_base else None
        return self.pipeline

    def _compile(self) -> None:
        """Use the program for what is wanted now; make it first if there is none yet."""
        if self.model is None:
            return
        self._worker.cancel((self, 'program'))
        needs = self.publishers.needs
        if not any(needs):
            self.publishers.deactivate()
            self._renew_pipeline().activate(None)
        elif needs in self._programs:
            self._activate(self._programs[needs])
        else:
            self._worker.submit(
                (self, 'program'),
                partial(compile_robot, self.model, needs, self.settings),
                partial(self._compiled, needs),
                lambda error: self._log.error(f'{self.name}: {error}'))

    def _compiled(self, needs: Needs, program: RobotProgram) -> None:
        self._programs[needs] = program
        self._activate(program)

    def _activate(self, program: RobotProgram) -> None:
        """Publish what this program computes from the next sample on."""
        if self._program is not None:       # postures of parallel robots go on
            program.continue_from(self._program)
        self._program = program
        kinematics = Kinematics(program, self.publishers.covariance, self.publishers.order)
        pipeline = self._renew_pipeline()
        pipeline.activate(kinematics)
        self.publishers.activate(program, self.model, self.settings,
                                 '' if pipeline.base is None else pipeline.base.world)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node: from joint states to the kinematic states of any number of robots."""
from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from time import monotonic
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType, JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from std_msgs.msg import String

from .backlog import Backlog
from .diagnostics import Diagnostics
from .own_ports import OwnPorts
from .parameters import as_values, NodeParameters
from .qos import latched_qos
from .requests import answer_always
from .robot import Robot
from .topic_inputs import BaseInput, by_topic, JointInput, TopicInput, WrenchInput
from .worker import Worker
from ..errors import ParameterError, ScrewKinematicsError
from ..pipeline.settings import RobotSettings

HOUSEKEEPING_PERIOD = 0.1
AWAITING_PERIOD, STARTING = 0.01, 2.0
"""Period [s] while work is under way, and in the first seconds, when listeners are found."""

PORTS_PERIOD = 1.0
"""Period [s] of looking after the ports of the middleware."""

HOW_TO_CONFIGURE = (
    'names of robots, and a description for each, for example: --ros-args -p robots:=[arm] '
    '-p arm.description:=package://screw_kinematics/config/robots/puma560.yaml; or a file of '
    'parameters such as share/screw_kinematics/config/kinematic_states.yaml, which must be for '
    'this very node, or /**')


@dataclass
class Before:
    """
    What a node goes on from: another one of this process, which the middleware left deaf.

    Its robots and inputs go over to the next node as they are, with all they know and counted;
    so do the values of its parameters. `given` names those that the user gave, `unknown` tells of
    those that do not exist.
    """

    parameters: tuple[Parameter, ...]
    given: frozenset[str]
    unknown: list[str]
    state: str
    robots: dict[str, Robot]
    inputs: dict[str, TopicInput[Any]]
    worker: Worker
    diagnostics: Diagnostics
    node: KinematicStatePublisher

    def end(self) -> None:
        """Let go all work and leave the middleware: no other node takes the place of this one."""
        self.worker.close()
        self.node.leave()


class KinematicStatePublisher(LifecycleNode):
    """
    Publishes twist, acceleration and more of end effectors, from joint states.

    A managed node: it reads its parameters and models when it is configured, and listens to joint
    states while it is active. It goes on from the node before it, if there was one;
    ``begin_again`` is called when the middleware has left it deaf: another one, with another
    context, is then to take its place. Options are as for ``rclpy.node.Node``.

    Raises
    ------
    ScrewKinematicsError
        With ``autostart``, if it cannot be configured.

    """

    def __init__(self, before: Before | None = None,
                 begin_again: Callable[[], None] | None = None, **options: Any) -> None:
        if before is not None:
            options['parameter_overrides'] = list(before.parameters)
        super().__init__('kinematic_state_publisher', start_parameter_services=False, **options)
        self.robots: dict[str, Robot] = {}
        self.inputs: dict[str, TopicInput[Any]] = {}
        self.failure: ScrewKinematicsError | None = None
        self.unknown_parameters: list[str] = [] if before is None else before.unknown
        self.state = 'unconfigured'
        self._descriptions: list[Any] = []
        self._plans: dict[str, tuple[Any, Any]] = {}
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        if before is None:
            self._worker, self._diagnostics = Worker(), Diagnostics(self)
        else:
            self._worker, self._diagnostics = before.worker, before.diagnostics
            self._diagnostics.join(self)
        self._begin_again, self._deaf = begin_again, False
        self._ports = OwnPorts()
        try:
            self._start(before)
            if before is not None:
                self._go_on(before)
        except ScrewKinematicsError:
            self.destroy_node()
            raise
        # Last of all: the first line that rclpy logs takes as long as finding publishers.
        if before is None:
            self._log_models()
            self._diagnostics.log_core()

    def _start(self, before: Before | None) -> None:
        self._settings = NodeParameters(self, None if before is None else before.given)
        self._settings.check_qos_overrides()
        settings = self._settings.node_settings()
        if settings.allow_remote_parameters:
            self._remote_parameters = ParameterService(self)
        answer_always(self, self._possible_transitions)
        self._report = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._jumps = self.get_clock().create_jump_callback(
            JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1)),
            post_callback=self._clock_jumped)
        self._started = monotonic()
        self.create_timer(PORTS_PERIOD, self._look_after_ports, clock=self._steady)
        self._house = self.create_timer(AWAITING_PERIOD, self._keep_house, clock=self._steady)
        self._report_timer = self.create_timer(1.0, self._publish_diagnostics, clock=self._steady)
        self._set_report_rate(settings.diagnostics_rate)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._parameters_changed)
        for name in settings.robots:
            self._settings.declare_robot(name)
        self._starting = settings.autostart and before is None
        if self._starting:
            for transition in (self.trigger_configure, self.trigger_activate):
                transition()
                if self.failure is not None:
                    raise self.failure
            self._starting = False

    def _go_on(self, before: Before) -> None:
        """Become as another node was."""
        state = before.state
        self.robots, self.inputs = before.robots, before.inputs
        if state in ('inactive', 'active') and self.state == 'unconfigured':
            self.trigger_configure()
        if state == 'active' and self.state == 'inactive':
            self.trigger_activate()
        if state == 'finalized':
            self.trigger_shutdown()

    def hand_over(self) -> Before:
        """Return what another node in the place of this one is to go on from; this one is over."""
        worker, self._worker = self._worker, Worker()
        parameters = tuple(parameter for parameter in self._parameters.values()
                           if parameter.type_ is not Parameter.Type.NOT_SET)
        return Before(parameters, self._settings.given, self.unknown_parameters, self.state,
                      self.robots, self.inputs, worker, self._diagnostics, self)

    # Life cycle

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read parameters and models; create the topics."""
        return self._attempt(self._configure, self._clean_up, 'inactive')

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to listen to joint states."""
        return self._attempt(self._subscribe, self._unsubscribe, 'active')

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Listen to joint states no more."""
        self._unsubscribe()
        for robot in self.robots.values():
            robot.reset()
        self.state = 'inactive'
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Remove the topics and forget the models."""
        self._clean_up()
        self.state = 'unconfigured'
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Remove the topics, for good."""
        self._clean_up()
        self.state = 'finalized'
        return super().on_shutdown(state)

    def destroy_node(self) -> None:
        """Stop the background work too."""
        self._worker.close()
        super().destroy_node()

    def leave(self) -> None:
        """Destroy the node, and leave the middleware at once."""
        self.destroy_node()
        # Else the garbage collector does this, perhaps while the interpreter ends.
        self._state_machine.destroy_when_not_in_use()

    def _possible_transitions(self) -> list[tuple[int, str]]:
        return [(number, label) for number, label, *_ in self._state_machine.available_transitions]

    def _attempt(self, action: Callable[[], None], undo: Callable[[], None], state: str,
                 ) -> TransitionCallbackReturn:
        """Do what a transition asks for, or tell what was in the way and undo it."""
        self.failure = None
        try:
            action()
        except Exception as error:      # rclpy would end the transition without a word
            self.failure = error if isinstance(error, ScrewKinematicsError) else (
                ScrewKinematicsError(f'{type(error).__name__}: {error}'))
            if not self._starting:      # else it is raised, for one line in all
                self.get_logger().error(f'cannot become {state}: {self.failure}')
            undo()
            return TransitionCallbackReturn.FAILURE
        self.state = state
        return TransitionCallbackReturn.SUCCESS

    def _configure(self) -> None:
        settings = self._settings.node_settings()
        if not settings.robots:
            misspelt = [s for s in self._settings.unknown() if 'did you mean' in s]
            raise ParameterError('robots', [], '; '.join([HOW_TO_CONFIGURE, *misspelt]))
        for name in settings.robots:
            self._settings.declare_robot(name)
        if self.robots:     # those of the node before
            for robot in self.robots.values():
                robot.join(self)
            for each in self.inputs.values():
                each.join(self)
        else:
            self._create([self._settings.robot_settings(name) for name in settings.robots])
            if not self._starting:
                self._log_models()
        undescribed = [r for r in self.robots.values() if not r.settings.description]
        for topic, listeners in by_topic(
                self, undescribed, 'description_topic',
                lambda r: [r.settings.description_topic]).items():
            self._descriptions.append(self.create_subscription(
                String, topic, partial(_described, listeners), latched_qos()))

    def _create(self, every: list[RobotSettings]) -> None:
        """Create the robots and their inputs."""
        for settings in every:
            robot = Robot(self, settings, self._worker)
            self.robots[robot.name] = robot
            if settings.description:
                robot.load_from_parameter()
        self._create_inputs(partial(JointInput, backlog=Backlog()), 'joint_states_topic',
                            lambda r: r.settings.joint_states_topic)
        self._create_inputs(WrenchInput, 'wrench_topic',
                            lambda r: [part.wrench_topic for part in r.settings.parts])
        self._create_inputs(BaseInput, 'base_motion_topic',
                            lambda r: [r.settings.base_motion_topic])

    def _log_models(self) -> None:
        for robot in self.robots.values():
            self.get_logger().info(f'{robot.name}: ' + (
                f'waiting for a description on {robot.settings.description_topic!r}'
                if robot.model is None else repr(robot.model)))

    def _create_inputs(self, kind: Callable[..., TopicInput[Any]], parameter: str,
                       topics: Callable[[Robot], Iterable[str]]) -> None:
        for topic, robots in by_topic(self, self.robots.values(), parameter, topics).items():
            if topic in self.inputs:
                raise ParameterError(f'{robots[0].name}.{parameter}', topic,
                                     f'another topic than that of {self.inputs[topic].content}')
            self.inputs[topic] = kind(self, topic, robots)

    def _subscribe(self) -> None:
        for each in self.inputs.values():
            each.open()
        # Only now all parameters exist, those of the subscriptions' quality of service too.
        told = self.unknown_parameters
        self._see_parameters()
        for sentence in self.unknown_parameters:
            if sentence not in told:
                self.get_logger().warning(sentence)

    def _see_parameters(self) -> None:
        self.unknown_parameters = self._settings.unknown(
            topic for topic, each in self.inputs.items() if each.type is None)

    def _unsubscribe(self) -> None:
        for each in self.inputs.values():
            each.close()

    def _clean_up(self) -> None:
        for subscription in self._descriptions:
            self.destroy_subscription(subscription)
        self._descriptions.clear()
        self._unsubscribe()
        self.inputs.clear()
        for robot in self.robots.values():
            robot.close()
        self.robots.clear()
        # The robots of the next configuration count from zero.
        self._diagnostics = Diagnostics(self, self._diagnostics.times_deaf)

    # At low rate

    def _keep_house(self) -> None:
        self._diagnostics.note_stop(HOUSEKEEPING_PERIOD)
        self._worker.collect()
        now = self.get_clock().now().nanoseconds * 1e-9
        for robot in self.robots.values():
            robot.update_demand(now)
        if any([each.look() for each in self.inputs.values()]):
            self._see_parameters()
        self._diagnostics.log_news(self.inputs, self.robots.values())
        self._pace_housekeeping()

    def _look_after_ports(self) -> None:
        ports = self._ports.deaf()
        if ports and self._begin_again is not None and not self._deaf:
            self._deaf = True
            self.get_logger().error(
                'deaf: Fast DDS listens to a port in shared memory that has been deleted '
                f"({', '.join(ports)}), as may happen after the process stood still; the node "
                'leaves the middleware and joins it anew')
            self._begin_again()

    def _pace_housekeeping(self) -> None:
        """Look more often while something is awaited."""
        awaiting = self._worker.pending or monotonic() - self._started < STARTING
        period_ns = round(1e9 * (AWAITING_PERIOD if awaiting else HOUSEKEEPING_PERIOD))
        if self._house.timer_period_ns != period_ns:
            self._house.timer_period_ns = period_ns
            self._house.reset()

    def _publish_diagnostics(self) -> None:
        self._report.publish(self.report())

    def report(self) -> DiagnosticArray:
        """Return the message for /diagnostics."""
        return self._diagnostics.report(
            self.get_clock().now(), self.state, self.inputs, self.robots.values(),
            self.unknown_parameters, self.failure)

    def _set_report_rate(self, rate: float) -> None:
        if rate > 0:
            self._report_timer.timer_period_ns = round(1e9 / rate)
            self._report_timer.reset()
        else:
            self._report_timer.cancel()

    def _clock_jumped(self, jump: TimeJump) -> None:
        for robot in self.robots.values():
            robot.reset()

    # Parameters

    def _check_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        values = as_values(parameters)
        self._plans = {}
        try:
            self._settings.check_changeable(values, configured=bool(self.robots))
            for name, value in values.items():
                self._settings.check_value(name, value)
            for name, robot in self.robots.items():
                if any(changed.startswith(f'{name}.') for changed in values):
                    settings = self._settings.robot_settings(name, values)
                    self._plans[name] = settings, robot.plan(settings)
        except ScrewKinematicsError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _parameters_changed(self, parameters: list[Parameter]) -> None:
        changed = as_values(parameters)
        if 'robots' in changed:     # so that the parameters of new robots can be set, too
            for name in self._settings.node_settings().robots:
                self._settings.declare_robot(name)
        plans, self._plans = self._plans, {}
        for name, (settings, model) in plans.items():
            self.robots[name].carry_out(settings, model)
        if 'diagnostics_rate' in changed:
            self._set_report_rate(self._settings.node_settings().diagnostics_rate)


def _described(robots: list[Robot], message: String) -> None:
    for robot in robots:
        robot.load_from_topic(message.data)

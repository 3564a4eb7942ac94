# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Answers to what other nodes ask for: whatever they send, there is one, and the node goes on.

rclpy lets an exception of a service's callback end the process, and raises one itself where
a transition is asked for that the present state does not have, or a value has no type.
"""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter

from .parameters import no_such_parameter
from ..errors import ParameterError

Callback = Callable[[Any, Any], Any]


def answer_always(node: Node, possible: Callable[[], Sequence[tuple[int, str]]]) -> None:
    """
    Answer every request of the services that the node has, and log why one is refused.

    ``possible`` returns number and label of the transitions that the present state has.
    """
    for service in node.services:
        if service.srv_type in (SetParameters, SetParametersAtomically):
            service.callback = _naming(node, service.callback)
        service.callback = _answering(node, service.srv_type, service.callback)
        if service.srv_type is ChangeState:
            service.callback = _refusing_impossible(node, service.callback, possible)


def _answering(node: Node, kind: Any, callback: Callback) -> Callback:
    def answer(request: Any, response: Any) -> Any:
        try:
            return callback(request, response)
        except Exception as error:
            problem = ' '.join(str(error).split()) or type(error).__name__
            node.get_logger().error(f'refused a request of {kind.__name__}: {problem}',
                                    throttle_duration_sec=1.0)
            return _failure(kind, request, problem)
    return answer


def _failure(kind: Any, request: Any, problem: str) -> Any:
    """Return the response that says no, in the words that its type has for it."""
    response = kind.Response()
    result = SetParametersResult(successful=False, reason=problem)
    if kind is SetParametersAtomically:
        response.result = result
    elif kind is SetParameters:
        response.results = [result] * len(request.parameters)
    return response


def _refusing_impossible(node: Node, callback: Callback,
                         possible: Callable[[], Sequence[tuple[int, str]]]) -> Callback:
    def answer(request: Any, response: Any) -> Any:
        asked = request.transition
        present = possible()
        # As rclpy has it, a label goes before a number.
        if (asked.label not in dict(present).values() if asked.label
                else asked.id not in dict(present)):
            node.get_logger().error(
                f'transition {asked.label or asked.id!r} is not possible now; '
                'possible: ' + (', '.join(f'{n} {text!r}' for n, text in present)
                                or 'none, the node is shut down'))
            response.success = False
            return response
        return callback(request, response)
    return answer


def _naming(node: Node, callback: Callback) -> Callback:
    """Refuse by name, and take what is unchanged; rclpy gives no name, or an empty list."""
    def answer(request: Any, response: Any) -> Any:
        judged = [_judgement(node, parameter) for parameter in request.parameters]
        refused = next((each for each in judged if each and not each.successful), None)
        if isinstance(response, SetParametersAtomically.Response) and refused:
            response.result = refused
            return response
        left = [p for p, each in zip(request.parameters, judged) if each is None]
        response = callback(type(request)(parameters=left), response)
        if isinstance(response, SetParametersAtomically.Response):
            if len(left) == 1:
                _name(left[0], response.result)
            return response
        results = iter(response.results)
        response.results = [each or _name(parameter, next(results))
                            for parameter, each in zip(request.parameters, judged)]
        return response
    return answer


def _judgement(node: Node, parameter: Any) -> SetParametersResult | None:
    """Return what there is to say whatever the node's own checks say, if there is anything."""
    name = parameter.name
    if not node.has_parameter(name):
        return SetParametersResult(successful=False, reason=no_such_parameter(
            name, node.list_parameters([], 0).names))
    if not node.describe_parameter(name).read_only:
        return None
    present = node.get_parameter(name)
    if parameter.value == present.get_parameter_value():    # as of a dump that is loaded again
        return SetParametersResult(successful=True)
    return SetParametersResult(successful=False, reason=str(ParameterError(
        name, Parameter.from_parameter_msg(parameter).value,
        f'{present.value!r} until the node is started again')))


def _name(parameter: Any, result: SetParametersResult) -> SetParametersResult:
    if not result.successful and parameter.name not in result.reason:
        result.reason = f'parameter {parameter.name!r}: {result.reason}'
    return result

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The errors of the package.

Every error raised on purpose derives from :class:`ScrewKinematicsError`, and from the
built-in exception a caller would expect, so both ``except ScrewKinematicsError`` and
``except ValueError`` work. A message names the place (file, robot, joint, parameter),
the value that was given, and what is allowed.
"""
from __future__ import annotations

from array import array
from collections.abc import Iterable
from enum import Enum
from importlib import import_module
import sys
from typing import Any

__all__ = ['AssemblyModeError', 'ClosureError', 'InvalidValueError', 'MalformedMessageError',
           'MissingExtraError', 'ModelError', 'ParameterError', 'Reason', 'ScrewKinematicsError',
           'ShapeError', 'SingularityError', 'ToolError', 'UnknownNameError']


class ScrewKinematicsError(Exception):
    """Base class of all errors of this package."""


class ShapeError(ScrewKinematicsError, ValueError):
    """
    An array has the wrong shape.

    Parameters
    ----------
    name : str
        Of the array.
    expected : str
        The allowed shape, as ``'(..., 6)'``.
    actual : tuple of int
        The one it has.

    """

    def __init__(self, name: str, expected: str, actual: tuple[int, ...]) -> None:
        super().__init__(f'{name}: expected shape {expected}, got {tuple(actual)}')


class InvalidValueError(ScrewKinematicsError, ValueError):
    """A value is outside what is allowed."""


class UnknownNameError(ScrewKinematicsError, KeyError):
    """
    A name is not one of the known ones; the message lists those that are.

    Parameters
    ----------
    what : str
        What is named.
    name : object
        The unknown name.
    known : iterable of str
        Those that exist.

    """

    def __init__(self, what: str, name: object, known: Iterable[str]) -> None:
        known = list(known)
        listed = ', '.join(repr(k) for k in known) if known else 'none'
        super().__init__(f'unknown {what} {name!r}; known: {listed}')

    def __str__(self) -> str:
        # KeyError shows the repr of its argument, which would quote the message twice.
        return str(self.args[0])


class ModelError(ScrewKinematicsError, ValueError):
    """
    A robot description cannot be turned into a chain.

    Parameters
    ----------
    source : str
        File or topic it came from.
    problem : str
        What is wrong where, and what is allowed.

    """

    def __init__(self, source: str, problem: str) -> None:
        self.source = source
        self.problem = problem
        super().__init__(f'{source}: {problem}')


class ParameterError(ScrewKinematicsError, ValueError):
    """
    A node parameter or command line option has a wrong value.

    Parameters
    ----------
    parameter : str
        Its full name.
    value : object
        What it was set to.
    allowed : str
        What may stand there.

    """

    def __init__(self, parameter: str, value: object, allowed: str) -> None:
        shown = 'not given' if value is None else repr(
            list(value) if isinstance(value, array) else value)     # as rclpy hands lists over
        super().__init__(f'parameter {parameter!r} is {shown}; allowed: {allowed}')


class SingularityError(ScrewKinematicsError, ValueError):
    """
    An inverse problem has no exact solution; ``screw`` is the blocked direction.

    Parameters
    ----------
    message : str
        What cannot be reached, and why.
    screw : object, optional
        The reciprocal screw that the wanted motion works against.

    """

    def __init__(self, message: str, screw: object = None) -> None:
        self.screw = screw
        super().__init__(message)


class ToolError(ScrewKinematicsError, RuntimeError):
    """A console program cannot go on: a process ended, a file is damaged, nothing came."""


class ClosureError(ScrewKinematicsError, ValueError):
    """
    A loop of a parallel manipulator does not close; ``limb`` and ``misfit`` say which.

    Parameters
    ----------
    limb : str
        Name of the limb.
    misfit : float
        How far its end is from the platform [m, with the characteristic length].
    problem : str
        How the search ended.

    """

    def __init__(self, limb: str, misfit: float, problem: str) -> None:
        self.limb = limb
        self.misfit = misfit
        super().__init__(f'the loop of limb {limb!r} does not close: {problem}')


class AssemblyModeError(ScrewKinematicsError, ValueError):
    """The loops of a parallel manipulator close in another assembly mode than before."""


class MissingExtraError(ScrewKinematicsError, ImportError):
    """
    An optional dependency cannot be imported.

    Raised where an ImportError is handled, it hands on what that said, unless it is just that
    the package is not there.

    Parameters
    ----------
    package : str
        Name it is imported by.
    extra : str
        The extra of this package that installs it.
    purpose : str
        What needs it.

    """

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        cause = sys.exc_info()[1]
        absent = not isinstance(cause, ImportError) or (
            isinstance(cause, ModuleNotFoundError) and cause.name == package)
        problem = 'is not installed' if absent else f'cannot be imported ({cause})'
        otherwise = (' (Linux on x86_64, Python 3.10 to 3.13), or source the setup file of a '
                     'ROS 2 installation') if extra == 'ros' else ''
        super().__init__(
            f'{purpose} needs the package {package!r}, which {problem}; '
            f"install it with: pip install 'screw_kinematics[{extra}]'{otherwise}")


def optional_module(module: str, extra: str, purpose: str, package: str = '') -> Any:
    """Import a module of an optional dependency; raise MissingExtraError if that is not there."""
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtraError(package or module.partition('.')[0], extra, purpose) from None


class MalformedMessageError(ScrewKinematicsError, ValueError):
    """
    The bytes of a message do not follow its type.

    Parameters
    ----------
    message_type : str
        As ROS writes it, such as 'sensor_msgs/JointState'.
    problem : str
        What does not fit.

    """

    def __init__(self, message_type: str, problem: str) -> None:
        super().__init__(f'a {message_type} message is malformed: {problem}')


class Reason(str, Enum):
    """
    Why a sample led to no output: what is counted at run time, instead of raised.

    Members are equal to their words, so that counts may be kept and read by either.

    Examples
    --------
    >>> Reason('estimator_settling').used, Reason.STAMP_NEGATIVE.used
    (True, False)
    >>> str(Reason.NAMED_TWICE)
    'joint_named_twice'

    """

    # Used all the same: the sample contributes to later outputs, or none was wanted.
    SETTLING = 'estimator_settling'
    MERGED = 'merged_with_later_ones'
    NOTHING_WANTED = 'nothing_wanted'
    # The message.
    MALFORMED = 'malformed_message'
    STAMP_NEGATIVE = 'stamp_negative'
    STAMP_NOT_FINITE = 'stamp_not_finite'
    STAMP_NOT_INCREASING = 'stamp_not_increasing'
    NO_TIME = 'no_stamp_and_no_clock_yet'
    # Its joints.
    NO_MODEL = 'no_model_yet'
    NO_JOINT = 'no_joint_of_robot'
    NAMED_TWICE = 'joint_named_twice'
    OWNED_BY_OTHERS = 'joints_come_with_other_message'
    JOINTS_MISSING = 'other_joints_missing'
    TOO_FAR_APART = 'joints_too_far_apart_in_time'
    # Its numbers.
    WRONG_LENGTH = 'position_of_wrong_length'
    NOT_FINITE = 'position_not_finite'
    NO_VELOCITY = 'velocity_not_measured'
    IMPLAUSIBLE_POSITION = 'implausible_position'
    IMPLAUSIBLE_JUMP = 'implausible_jump'
    NO_NEW_READING = 'no_new_reading'
    RUN_TOO_SHORT = 'run_too_short'
    # Another stream, read at the instant of the joints' motion.
    AWAITED = 'other_stream_awaited'
    NOT_COVERED = 'other_stream_has_a_gap'
    VALUES_NOT_FINITE = 'values_not_finite'
    UNKNOWN_FRAME = 'frame_not_fixed_to_tip'
    # The motion of the base.
    BASE_FRAME = 'frame_not_fixed_to_base'
    BASE_ORIENTATION = 'base_orientation_not_normalised'
    BASE_MISSING = 'base_motion_missing'
    BASE_TOO_OLD = 'base_motion_too_old'
    # What follows from them.
    NO_SOLUTION = 'no_state_at_this_posture'
    STATE_NOT_FINITE = 'state_not_finite'
    INTERNAL_ERROR = 'internal_error'

    @property
    def used(self) -> bool:
        """Whether the sample counts as used; else it was refused."""
        return self in _USED

    def __str__(self) -> str:
        return self.value


_USED = frozenset({Reason.SETTLING, Reason.MERGED, Reason.NOTHING_WANTED, Reason.AWAITED})

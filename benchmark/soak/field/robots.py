# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The robots of the field soak: how they move, how their drivers stamp, and what is true.

Each device reads its joints once in a millisecond, on ticks of its own. The motion repeats every
5000 ticks. Positions are rounded as by an encoder.
"""
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from screw_kinematics import models
from screw_kinematics.screws.rotations import pose
from screw_kinematics.tools.stamping import stampings

from ..robots import BASES, CONFIG, DESCRIPTIONS
from ...node.robot import message_body, TIP
from ...swinging import swing

RATE = 1000.0
SAMPLES = 5000
ENCODER = 1e-5
OFFSET = (0.1, 0.0, 0.1, 0.0, 0.0, 0.0)
"""The other `tool_offset` of robots that have two [m, rad]; one across a plane changes nothing."""

OUTPUTS = ('twist_with_covariance', 'accel_with_covariance')
ORDERS = dict(zip(OUTPUTS, (1, 2)))


class Message(NamedTuple):
    """A reading, the stamp it gets, what that is in true time, and when it is sent [s]."""

    reading: float
    stamp: float
    instant: float
    sent: float


def clean(every: float) -> Iterator[Message]:
    """Each reading has the stamp of its tick."""
    for reading, stamp, sent in stampings('exact', RATE):
        yield Message(reading, stamp, stamp, sent)


def arrival(every: float) -> Iterator[Message]:
    """Stamped by who receives it, some tenths of a millisecond later."""
    for reading, stamp, sent in stampings('arrival', RATE, seed=1):
        yield Message(reading, stamp, stamp, sent)


def reader(every: float) -> Iterator[Message]:
    """Let a loop with a clock of its own take the latest of 250 readings a second, and stall."""
    for reading, stamp, sent in stampings('held', RATE, seed=2):
        if stamp % 7.3 > 0.025:
            yield Message(reading, stamp, stamp, sent)


def clock_set(every: float) -> Iterator[Message]:
    """Right, by a clock that is set by 5 ms now and then, and slewed by 300 ppm."""
    rng = np.random.default_rng(3)
    for reading, _, sent in stampings('exact', RATE):
        wrong = 0.005 * (int(reading / every) % 2) + 3e-4 * abs(reading % 40.0 - 20.0)
        yield Message(reading, reading + wrong + rng.normal(0.0, 5e-6), reading, sent)


@dataclass(frozen=True)
class FieldRobot:
    """A robot and its driver."""

    name: str
    description: str    # empty: from the topic
    way: Callable[[float], Iterator[Message]]
    latency: float      # from a fresh reading to its stamp, on average [s]: nobody can know it
    velocity: bool      # whether velocities are measured
    delay: float        # of the estimates [s]

    @cached_property
    def chains(self) -> list[Any]:
        """Return the models that it may have at a time, as told by description or tool offset."""
        if not self.description:
            return [models.load_urdf(text, tip_frame=TIP) for text in DESCRIPTIONS]
        arm = models.load(self.description)
        return [arm, arm.with_tool(pose(translation=OFFSET[:3]), 'tool')]

    @property
    def parameters(self) -> dict[str, Any]:
        """Return the robot's parameters."""
        model = {'description': self.description} if self.description else {'tip_frame': TIP}
        return {**model, 'outputs': [*OUTPUTS, 'pose'], 'estimator': {'delay': self.delay},
                'joint_states_topic': f'{self.name}/joints'}

    def motion(self, t: np.ndarray) -> list[np.ndarray]:
        """Return positions, velocities and accelerations at instants [s], shape (N, n) each."""
        random, once = np.random.default_rng([ord(c) for c in self.name]), RATE / SAMPLES
        return swing(t, self.chains[0].dof, random,
                     ((once, 0.3), (3 * once, 0.1), (7 * once, 0.03)))

    def readings(self) -> list[tuple[list[float], list[float]]]:
        """Return what is measured at each tick: positions, and velocities if they are."""
        q, qd, _ = self.motion(np.arange(SAMPLES) / RATE)
        q = np.round(q / ENCODER) * ENCODER
        qd += np.random.default_rng(5).normal(0.0, 1e-4, qd.shape)
        return [(position, velocity if self.velocity else [])
                for position, velocity in zip(q.tolist(), qd.tolist())]

    def bodies(self) -> list[bytes]:
        """Return what follows the stamp in the message with each reading."""
        return [message_body(self.chains[0].joint_names, *reading) for reading in self.readings()]

    def truth(self, t: np.ndarray, model: int) -> dict[str, np.ndarray]:
        """Return what is true at instants [s], angular part first, shape (N, 6) each."""
        state = self.chains[model].state(*self.motion(t))
        return {output: state.classical(ORDERS[output]) for output in OUTPUTS}


ROBOTS = (
    FieldRobot('clean', f'{CONFIG}puma560.yaml', clean, 0.0, True, 0.0),
    FieldRobot('arrival', f'{CONFIG}panda.yaml', arrival, 4e-4, False, 0.02),
    FieldRobot('reader', f'{CONFIG}rpr.yaml', reader, 1e-3, False, 0.02),
    FieldRobot('set', '', clock_set, 0.0, False, 0.0))

__all__ = ['BASES', 'DESCRIPTIONS', 'FieldRobot', 'Message', 'OFFSET', 'OUTPUTS', 'ROBOTS']

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
The robots of the soak, their motion, and what the node has to say about it.

The motion repeats every 5 s, which divides an hour: a clock that jumps by hours leaves it
continuous, and the sample that an output describes is told by its stamp alone.
"""
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from geometry_msgs.msg import AccelStamped, TwistStamped
import numpy as np

from screw_kinematics import models

from ..node.robot import message_body, TIP, URDF
from ..swinging import swing

TICK_NS = 1_000_000
SAMPLES = 5000      # the motion repeats after this many ticks
KINDS = {'twist': TwistStamped, 'accel': AccelStamped}
RELAYED = 'relayed/'    # before the names of a relay's outputs
INPUT_DEPTH, OUTPUT_DEPTH = 100_000, 5_000

RIVAL_NS = TICK_NS // 2
"""Stamps of a second publisher lie this much beside those of the first."""


@dataclass(frozen=True)
class SoakRobot:
    """A robot and how the node is to treat it."""

    name: str
    parameters: dict[str, Any]    # of the node, for this robot
    exact: tuple[str, ...]        # outputs that follow from one sample; the others are estimated

    @property
    def outputs(self) -> tuple[str, ...]:
        """Return the names of the outputs."""
        return tuple(self.parameters['outputs'])

    @property
    def delay_ticks(self) -> int:
        """Return how long before the latest sample the outputs are, in ticks."""
        return round(self.parameters.get('estimator', {}).get('delay', 0.0) / (TICK_NS * 1e-9))

    @property
    def described(self) -> bool:
        """Whether its model comes from a topic."""
        return not self.parameters.get('description')

    @cached_property
    def chain(self) -> Any:
        """Return the model at the start."""
        if self.described:
            return models.load_urdf(DESCRIPTIONS[0], tip_frame=TIP)
        return models.load(self.parameters['description'])

    def motion(self, rival: bool = False) -> list[np.ndarray]:
        """Return positions, velocities and accelerations, each of shape (SAMPLES, n)."""
        random = np.random.default_rng([ord(c) for c in self.name] + [rival])
        once = 1 / (SAMPLES * TICK_NS * 1e-9)
        return swing(np.arange(SAMPLES) * TICK_NS * 1e-9, self.chain.dof, random,
                     ((once, 0.3), (2 * once, 0.1)))

    def bodies(self, rival: bool = False) -> list[bytes]:
        """Return what follows the stamp in the message of each sample."""
        q, qd, _ = self.motion(rival)
        names = self.chain.joint_names
        return [message_body(names, *sample) for sample in zip(q.tolist(), qd.tolist())]

    def expected(self, description: int = 0, rival: bool = False) -> dict[str, np.ndarray]:
        """
        Return what is true for each sample, angular part first, shape (SAMPLES, 6).

        From the recursion over the joints, or for a URDF by Pinocchio: not by the compiled
        program that the node runs.
        """
        motion = self.motion(rival)
        if self.described:
            return _by_pinocchio(DESCRIPTIONS[description], self.chain.joint_names, motion)
        state = self.chain.state(*motion)
        return {'twist': state.classical(1), 'accel': state.classical(2)}


def _by_pinocchio(urdf: str, names: tuple[str, ...], motion: list[np.ndarray],
                  ) -> dict[str, np.ndarray]:
    import pinocchio as pin
    full = pin.buildModelFromXML(urdf)
    still = [full.getJointId(name) for name in full.names[1:] if name not in names]
    model = pin.buildReducedModel(full, still, pin.neutral(full))
    data, tip = model.createData(), model.getFrameId(TIP)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    order = [names.index(name) for name in model.names[1:]]
    out = {'twist': np.empty((SAMPLES, 6)), 'accel': np.empty((SAMPLES, 6))}
    for i, sample in enumerate(zip(*motion)):
        pin.forwardKinematics(model, data, *(values[order] for values in sample))
        for name, value in (
                ('twist', pin.getFrameVelocity(model, data, tip, axes)),
                ('accel', pin.getFrameClassicalAcceleration(model, data, tip, axes))):
            out[name][i] = (*value.angular, *value.linear)
    return out


_PANDA = URDF.read_text()

DESCRIPTIONS = [_PANDA, _PANDA.replace('panda_link0', 'panda_linkB').replace('0.107', '0.157')]
"""Two robots with the same joints, told apart by the base frame, which is in every output."""

BASES = (b'panda_link0', b'panda_linkB')

BROKEN_DESCRIPTIONS = (
    _PANDA[:len(_PANDA) // 2],
    '',
    'not XML',
    '<robot name="r"><link name="only"/></robot>',
    _PANDA.replace('xyz="0 0 1"', 'xyz="0 nan 1"').replace('xyz="0 -0.316 0"', 'xyz="inf 0 0"'),
    '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    '<robot name="r"><link name="&b;"/></robot>')

CONFIG = 'package://screw_kinematics/config/robots/'

ROBOTS = (
    SoakRobot('puma', {
        'description': f'{CONFIG}puma560.yaml', 'velocity_source': 'measured',
        'outputs': ['twist', 'accel']}, exact=('twist',)),
    SoakRobot('panda', {
        'description': f'{CONFIG}panda.yaml', 'velocity_source': 'measured',
        'outputs': ['twist']}, exact=('twist',)),
    SoakRobot('rpr', {
        'description': f'{CONFIG}rpr.yaml', 'outputs': ['twist', 'accel'],
        'estimator': {'delay': 0.02}}, exact=()),
    SoakRobot('described', {
        'description_topic': 'robot_description', 'tip_frame': TIP,
        'velocity_source': 'measured', 'outputs': ['twist']}, exact=('twist',)))

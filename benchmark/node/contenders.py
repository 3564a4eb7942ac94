# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes that are compared, and how each is started."""
from collections.abc import Callable
from dataclasses import dataclass
import sys

from screw_kinematics.core import INTERPRETED
from screw_kinematics.node import fast_dds

from . import native
from .robot import BASE, TIP, URDF

OURS = 'import sys; from screw_kinematics.node.main import main; sys.exit(main())'
UNCOMPILED = f'import os; os.environ[{INTERPRETED!r}] = "1"; {OURS}'

ESTIMATORS_SETTLE = 12_000
"""Messages after which estimators seldom change what they take the noise for."""


@dataclass(frozen=True)
class Contender:
    """
    A node by name, its command for some robots, and the topics of each that it publishes.

    Before it is timed each of its robots gets `warm_up` messages, so that one robot, which gets
    them all, is not compared with many that have only begun.
    """

    name: str
    command: Callable[[int], list[str]]
    outputs: tuple[str, ...] = ('twist', 'accel')
    warm_up: int = 1000


def peer(kind: str, name: str) -> Contender:
    """Return one of the other nodes."""
    return Contender(name, lambda robots: [
        sys.executable, '-m', 'benchmark.node.peers', kind, str(robots)])


def ours(name: str, code: str, *parameters: str, outputs: tuple[str, ...] = ('twist', 'accel'),
         ) -> Contender:
    """Return our node, as users start it."""
    def command(robots: int) -> list[str]:
        names = [f'r{i}' for i in range(robots)]
        given = [f'robots:=[{", ".join(names)}]']
        for robot in names:
            given += [f'{robot}.{parameter}' for parameter in (
                f'description:={URDF}', f'base_frame:={BASE}', f'tip_frame:={TIP}',
                f'joint_states_topic:={robot}/joint_states', *parameters)]
        return [sys.executable, '-c', code, '--ros-args',
                *(word for parameter in given for word in ('-p', parameter))]
    return Contender(name, command, outputs, ESTIMATORS_SETTLE)


def native_nodes() -> list[Contender]:
    """Return the node in C++, plain and with our Fast DDS settings, if it can be built."""
    program = native.build()
    if program is None:
        return []
    settings: dict[str, str] = {}
    fast_dds.settle(settings)
    with_settings = ['env', *(f'{name}={value}' for name, value in settings.items())]
    return [Contender(NATIVE, lambda robots: [str(program), str(robots)]),
            Contender(f'{NATIVE}, our Fast DDS settings',
                      lambda robots: [*with_settings, str(program), str(robots)])]


NATIVE = 'C++ on rcl, no estimator'
FLOOR = 'floor of rclpy: raw relay, one long spin'
OWN = 'ours'
RELAY = 'rclpy relay'
PINOCCHIO = 'rclpy, Pinocchio, no estimator'

SCRIPTED = [
    peer('relay', RELAY),
    peer('pinocchio', PINOCCHIO),
    peer('numpy', 'rclpy, handwritten NumPy'),
    peer('raw_relay', FLOOR),
    ours(OWN, OURS),
    ours('ours, joint_motion too', OURS, 'outputs:=[twist, accel, joint_motion]',
         outputs=('twist', 'joint_motion', 'accel')),
    ours('ours, with covariances', OURS,
         'outputs:=[twist_with_covariance, accel_with_covariance]',
         outputs=('twist_with_covariance', 'accel_with_covariance')),
    ours('ours, three tips', OURS, f'tips:=[{TIP}, panda_hand, panda_link5]', outputs=tuple(
        f'{tip}/{output}' for tip in ('panda_link5', 'panda_hand', TIP)
        for output in ('twist', 'accel'))),
    ours('ours, core interpreted', UNCOMPILED),
    ours('ours, measured twist only', OURS,
         'outputs:=[twist]', 'velocity_source:=measured', outputs=('twist',)),
]
"""All but those that are built first; see :func:`native_nodes`."""

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The page: scene and panel, brought up to date some tens of times a second."""
from __future__ import annotations

from collections.abc import Sequence
import errno
import socket
from typing import Any

import numpy as np

from .meshes import load_meshes
from .motion import ShownMotion
from .panel import Panel, SPAN
from .scene import RobotScene
from ...errors import optional_module, ParameterError, ToolError

RATE = 30.0
"""How often the page is brought up to date [Hz]."""
_SERIES_RATE = 6.0
_GAP = 1.6      # between robots, in sizes of one


def open_server(host: str, port: int) -> Any:
    """Return a viser server that answers at an address."""
    viser = require_viser()
    _try_address(host, port)
    server = viser.ViserServer(host=host, port=port, verbose=False)
    server.scene.set_up_direction('+z')
    return server


def _try_address(host: str, port: int) -> None:
    """Raise what viser does not: its thread would end, and whoever opens it wait for ever."""
    if not 0 <= port < 2**16:
        raise ParameterError('port', port, '0 to 65535')
    try:
        family = socket.AF_INET6 if ':' in host else socket.AF_INET
        socket.create_server((host, port), family=family).close()
    except OSError as error:
        if error.errno != errno.EADDRINUSE:      # where somebody answers viser takes the next port
            raise ToolError(f'nobody can answer there: {error.strerror}') from None


def require_viser() -> Any:
    """Return viser; raise MissingExtraError if the page cannot be made."""
    return optional_module('viser', 'view', 'showing robots in the browser')


class Page:
    """Robots in a viser server's page; of live ones the latest state."""

    def __init__(self, server: Any, motions: Sequence[ShownMotion], live: bool = False) -> None:
        self._motions = list(motions)
        self._live = live
        self.panel = Panel(server, motions, live)
        self.scenes: list[RobotScene] = []
        self._remarks: list[str] = []
        size = max(motion.size for motion in motions)
        for k, motion in enumerate(motions):
            meshes, why = load_meshes(motion.description, motion.robot)
            self._remarks.append(f'skeleton only, no bodies: {why}' if why else '')
            self.scenes.append(RobotScene(server, motion, np.array([0, k * _GAP * size, 0]),
                                          meshes))
        server.scene.add_grid('/ground', 6 * size, 6 * size, cell_size=size / 4,
                              section_size=size)
        middle = np.mean([scene.middle for scene in self.scenes], axis=0)
        distance = size * (1 + 0.6 * (len(motions) - 1))
        server.initial_camera.position = middle + distance * np.array([1.3, 0.9, 0.6])
        server.initial_camera.look_at = middle
        self.time = 0.0
        self._slider = 0.0
        self._written = -np.inf
        self._describe()

    def step(self, seconds: float) -> None:
        """Go on by the time that has passed, and show what is there then."""
        panel = self.panel
        if self._live:
            self.time = max(motion.end for motion in self._motions)
        elif panel.time.value != self._slider:      # somebody moved it
            self.time = panel.time.value
        else:
            self.time = (self.time + seconds * panel.pace) % (panel.time.max or 1.0)
        if not self._live:
            self._slider = panel.time.value = round(self.time / panel.time.step) * panel.time.step
        self._written += seconds
        changed = False
        for motion, scene in zip(self._motions, self.scenes):
            scene.shown = {name: box.value for name, box in panel.shown.items()}
            changed |= scene.factor != panel.factor.value
            scene.factor = panel.factor.value
            if self._live:
                changed |= scene.fit(motion.window(motion.end, SPAN))
            snapshot = motion.at(self.time)
            if snapshot is not None:
                scene.show(snapshot)
        if changed or self._written == -np.inf or self._written > 1 / _SERIES_RATE:
            self._written = 0.0
            self._describe()
            snapshot = self._chosen[0].at(self.time)
            if snapshot is not None:
                panel.write(self._chosen[0], snapshot)

    @property
    def _chosen(self) -> tuple[ShownMotion, RobotScene, str]:
        """Return the robot that the panel is about."""
        name = self.panel.robot.value
        k = next(k for k, motion in enumerate(self._motions) if motion.name == name)
        return self._motions[k], self.scenes[k], self._remarks[k]

    def _describe(self) -> None:
        self.panel.describe(*self._chosen)

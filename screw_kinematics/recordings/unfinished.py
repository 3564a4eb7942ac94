# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Outputs that are there whole or not at all."""
from __future__ import annotations

import os
from pathlib import Path
import shutil


class Unfinished:
    """
    A temporary folder beside the outputs, which come to their places when all is well.

    It is made within the context, so that whatever comes in between finds it looked after.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.folder = folder
        self.path = folder / f'.{name}.unfinished'
        self.finished: list[Path] = []

    def __enter__(self) -> Unfinished:
        return self

    def __exit__(self, error: object, *_: object) -> None:
        if error is None:
            self._put(self.path)
        if self.path.exists():
            shutil.rmtree(self.path)

    def make(self) -> Path:
        """Make the folder; what an earlier try under this name left is removed."""
        shutil.rmtree(self.path, ignore_errors=True)
        self.path.mkdir(parents=True)
        return self.path

    def _put(self, folder: Path) -> None:
        """Move what is in a folder to its place; folders that are there get what is new."""
        for made in sorted(folder.iterdir()):
            place = self.folder / made.relative_to(self.path)
            if place.is_dir() and '=' in made.name:      # of a data set
                self._put(made)
                continue
            if place.is_dir():
                shutil.rmtree(place)
            os.replace(made, place)
            self.finished.append(place)

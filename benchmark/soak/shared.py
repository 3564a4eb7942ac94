# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the source has done, in memory that outlives it."""
import mmap
from pathlib import Path

_PER_ROBOT = 3
RING = 1 << 16


class Progress:
    """
    Counts and times of a source, for another process to read, even after it was killed.

    They are in a file that is made if it does not exist. ``numbers[0]`` is that of the last
    command that was done, ``numbers[1]`` when the source was alive last [ns, monotonic]; then come
    those of each robot, where the methods say.
    """

    def __init__(self, file: Path, robots: int) -> None:
        self._robots = robots
        count = 2 + robots * (_PER_ROBOT + RING)
        if not file.exists():
            file.write_bytes(bytes(8 * count))
        with open(file, 'r+b') as opened:
            self.numbers = memoryview(mmap.mmap(opened.fileno(), 8 * count)).cast('q')

    def published(self, robot: int) -> int:
        """Return where the number of messages published is."""
        return 2 + _PER_ROBOT * robot

    def tick(self, robot: int) -> int:
        """Return where the next tick of a robot's clock is."""
        return 3 + _PER_ROBOT * robot

    def times(self, robot: int) -> int:
        """Return where the times of publishing begin, by tick modulo RING [ns, monotonic]."""
        return 2 + _PER_ROBOT * self._robots + RING * robot

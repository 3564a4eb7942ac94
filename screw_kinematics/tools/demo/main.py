# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Watch the kinematic state publisher at work, without a robot.

Starts the node and, in another process, a JointState publisher that moves the robot by
a motion which is known exactly; shows what the node publishes beside the truth.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import suppress
import time
from typing import Any

from rich.console import Console
from rich.live import Live

from .view import comparison, line, LiveTable, View
from .truth import rows
from .. import console, stage
from ..listener import Listener, stamp_of
from ..processes import Children
from ..view.main import add_page_options, check_page_options, show_stage
from ...errors import ToolError
from ...node.stop_request import StopRequest

EXAMPLES = """\
  demo                                    the PUMA 560 in the paper's motion, 100 Hz
  demo --once                             one state beside the exact one, then exit
  demo --motion minjerk --rate 500 --delay 0.02
  demo --robot panda.urdf --base panda_link0 --tip panda_hand_tcp --motion multisine
  demo --rate 1000 --stamps arrival       what the estimator makes of usual stamps
  demo --view                             the same in the browser
  demo --duration 10 | tee demo.log       plain lines, one a second, for 10 s
"""
_PATIENCE = 60.0
_SETTLING, _GAP = 1.0, 0.2
"""Time in which the estimator settles, and pause after which it has to again [s]."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tool; see ``demo --help``."""
    options = console.parser('demo', __doc__ or '', EXAMPLES)
    stage.add_options(options)
    how = options.add_mutually_exclusive_group()
    how.add_argument('--once', action='store_true',
                     help='print one state, measured and exact, and exit')
    how.add_argument('--view', action='store_true', help='show it in the browser')
    add_page_options(options, '--duration')
    return console.run(demonstrate, options, argv)


def demonstrate(arguments: argparse.Namespace) -> int:
    """Start node and joint states, show states, end both."""
    check_page_options(arguments)
    played = stage.Stage(arguments)
    if arguments.view:
        with StopRequest() as stop:
            show_stage(arguments, played, stop)
        return console.OK
    with StopRequest() as stop, Children() as children:
        played.run(children)
        with _Watch(arguments, played, children, stop) as watch:
            watch.wait_for_states()
            if arguments.once:
                watch.show_one()
            else:
                watch.show_all()
    return console.OK


class _Watch(Listener):
    """The part of the demo that listens and shows."""

    def __init__(self, arguments: argparse.Namespace, played: stage.Stage,
                 children: Children, stop: StopRequest) -> None:
        from geometry_msgs.msg import AccelStamped, PoseStamped, TwistStamped
        from sensor_msgs.msg import JointState
        self._arguments = arguments
        self._stage = played
        self._children = children
        self._stop = stop
        self._outputs = [f'{played.name}/{output}' for output in stage.OUTPUTS]
        kinds = dict(zip(self._outputs, (PoseStamped, TwistStamped, AccelStamped)))
        super().__init__({'joint_states': JointState, **kinds}, 'demo', f'/{played.namespace}')
        self._terminal = Console(highlight=False)
        base, tip = played.robot.base_frame, played.robot.tip_frame
        self._title = f'/{played.namespace}/{played.name}, motion {arguments.motion}'
        self._frames = (f'motion of {tip} relative to {base}; axes of {base}; '
                        f'reference point: origin of {tip}')

    def wait_for_states(self) -> None:
        """Wait until every output has come at least once."""
        end = time.monotonic() + _PATIENCE
        streams = self.streams
        while not all(stream.count for stream in streams.values()):
            self.listen(0.1)
            if time.monotonic() > end:
                silent = ', '.join(topic for topic, s in streams.items() if not s.count)
                raise ToolError(f'no message within {_PATIENCE:.0f} s on: {silent}')

    def show_one(self) -> None:
        """Print one state beside the exact one, after the estimator has settled."""
        begin = last = self._time()
        while last - begin < _SETTLING + self._arguments.delay:
            self.listen(0.05)
            now = self._time()
            if now - last > _GAP:
                begin = now
            last = now
        print(comparison(self._view()))

    def _time(self) -> float:
        """Return the instant of the newest state [s]."""
        return stamp_of(self.streams[self._outputs[0]].message()) * 1e-9

    def show_all(self) -> None:
        """Show states until the time is over or a signal comes."""
        end = time.monotonic() + self._arguments.seconds
        interactive = self._terminal.is_terminal
        # Ctrl-C is how a live view is left; before there is one it is an interruption.
        with Live(console=self._terminal, auto_refresh=False) as live, \
                suppress(KeyboardInterrupt):
            while (left := end - time.monotonic()) > 0:
                self.listen(min(0.1 if interactive else 1.0, left))
                view = self._view()
                if interactive:
                    live.update(LiveTable(view), refresh=True)
                else:
                    print(line(view), flush=True)

    def listen(self, seconds: float) -> None:
        """Receive messages for a while; raise if asked to stop or if a process ended."""
        super().listen(seconds)
        if self._stop.made:
            raise KeyboardInterrupt
        self._children.check()

    def _view(self) -> View:
        pose, twist, accel = self._matching()
        stamp = stamp_of(twist)
        return View(
            self._title, self._frames, self._stage.elapsed(stamp),
            rows(self._stage.exact(stamp), pose.pose, twist.twist, accel.accel),
            {topic: stream.rate() for topic, stream in self.streams.items()},
            (time.time_ns() - stamp) * 1e-9, self._arguments.delay)

    def _matching(self) -> list[Any]:
        """Return the newest pose, twist and acceleration of one stamp."""
        while True:
            newest = [self.streams[topic].message() for topic in self._outputs]
            if len({stamp_of(message) for message in newest}) == 1:
                return newest
            self.listen(0.001)

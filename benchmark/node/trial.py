# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One node under load: start-up, saturation, 1 kHz, and silence."""
from dataclasses import dataclass
import os
from pathlib import Path
import signal
import statistics
from struct import unpack_from
import subprocess
import time

import domain_coordinator
from geometry_msgs.msg import AccelStamped, TwistStamped
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from screw_kinematics.ros import middleware
from sensor_msgs.msg import JointState

from .contenders import Contender
from .robot import Driver, PERIOD_NS

WINDOW = 50         # messages under way at most, fewer than any queue holds: nothing is lost
WARM_UP = 4000      # messages for each robot, after which estimators have converged
PATIENCE = 60.0     # for a node to start [s]
SILENCE = 5.0       # without any output, after which what is under way counts as lost [s]
MESSAGES = {'twist': TwistStamped, 'accel': AccelStamped}


@dataclass
class Figures:
    """What one trial measured; see the fields' names for units."""

    start_s: float = 0.0
    cpu_us: float = 0.0
    rate: float = 0.0
    lost: int = 0
    p50_us: float = 0.0
    p99_us: float = 0.0
    cpu_1khz_us: float = 0.0
    idle_percent: float = 0.0
    rss_mib: float = 0.0


class Trial:
    """
    Drives a node that runs in another process.

    Messages are published serialized, and outputs are counted without reading them, so that
    the driving side stays well below the node's own cost. Every sample of every robot is
    expected to lead to each of the outputs; the last one of them is counted.
    """

    def __init__(self, contender: Contender, robots: int) -> None:
        self._contender, self._robots = contender, robots
        self._drivers = [Driver(seed) for seed in range(robots)]
        self._sent = self._received = 0
        self._turn = 0
        self._refill = False
        self._due: dict[int, float] = {}
        self._latencies: list[float] | None = None

    def run(self, seconds: float, full: bool) -> Figures:
        """Return the figures; those but saturation only if a full trial is asked for."""
        with domain_coordinator.domain_id() as domain:
            os.environ.update(
                {'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'})
            # Of the driver alone: contenders have their own settings, or none.
            os.environ.pop(middleware.PROFILES, None)
            environment = dict(os.environ)
            middleware.settle()
            context = rclpy.Context()
            rclpy.init(context=context, domain_id=domain)
            self._connect(context)
            started = time.perf_counter()
            process = subprocess.Popen(self._contender.command(self._robots), env=environment,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            try:
                figures = self._measure(process, started, seconds, full)
                process.send_signal(signal.SIGINT)
                process.wait(PATIENCE)
            finally:
                process.kill()
                self._executor.shutdown()
                for node in self._nodes:
                    node.destroy_node()
                context.try_shutdown()
        return figures

    def _connect(self, context: rclpy.Context) -> None:
        counting = rclpy.create_node('counting', context=context)
        # Its messages are never taken: it is there so that the node publishes everything.
        silent = rclpy.create_node('silent', context=context)
        *others, counted = self._contender.outputs
        self._publish = []
        for i in range(self._robots):
            self._publish.append(counting.create_publisher(
                JointState, f'r{i}/joint_states', QoSProfile(depth=100)).publish)
            counting.create_subscription(
                MESSAGES[counted], f'r{i}/{counted}', self._count, 100, raw=True)
            for output in others:
                silent.create_subscription(
                    MESSAGES[output], f'r{i}/{output}', lambda _: None, 1, raw=True)
        self._nodes = counting, silent
        self._executor = EventsExecutor(context=context)
        self._executor.add_node(counting)

    def _measure(self, process: subprocess.Popen, started: float, seconds: float,
                 full: bool) -> Figures:
        figures = Figures()
        # One sample each millisecond, until every robot has answered.
        while self._received < 20 * self._robots:
            if process.poll() is not None or time.perf_counter() - started > PATIENCE:
                process.kill()
                assert process.stderr is not None
                raise RuntimeError(f'{self._contender.name} does not answer: '
                                   f'{process.stderr.read().decode()[-2000:]}')
            self._send()
            self._spin_until(time.perf_counter() + 1e-3 / self._robots)
            if self._received and not figures.start_s:
                figures.start_s = time.perf_counter() - started
        clock = (~process.pid << 3) | 2     # CPU time of another process: clock_getcpuclockid(3)
        self._wait_for_compilers(clock)
        self._give_up()
        self._saturate(WARM_UP * self._robots)

        received, cpu, begin = self._received, time.clock_gettime(clock), time.perf_counter()
        figures.lost = self._saturate(seconds=seconds)
        count = self._received - received
        figures.cpu_us = (time.clock_gettime(clock) - cpu) / count * 1e6
        figures.rate = count / (time.perf_counter() - begin)
        if full:
            cpu = time.clock_gettime(clock)
            self._at_1khz(round(seconds * 1000), figures)
            figures.cpu_1khz_us = (
                (time.clock_gettime(clock) - cpu) / len(self._latencies or [1]) * 1e6)
            figures.rss_mib = _resident_mib(process.pid)
            self._spin_until(time.perf_counter() + 1.0)
            cpu, begin = time.clock_gettime(clock), time.perf_counter()
            self._spin_until(begin + 2 * seconds)
            figures.idle_percent = (
                (time.clock_gettime(clock) - cpu) / (time.perf_counter() - begin) * 100)
        return figures

    def _wait_for_compilers(self, clock: int) -> None:
        """Send nothing until the node rests, as it does once its work in the background ends."""
        end = time.perf_counter() + PATIENCE
        busy = True
        while busy and time.perf_counter() < end:
            cpu = time.clock_gettime(clock)
            self._spin_until(time.perf_counter() + 0.5)
            busy = time.clock_gettime(clock) - cpu > 0.02

    def _saturate(self, messages: int | None = None, seconds: float = 2 * PATIENCE) -> int:
        """Keep the window full for some messages or some time; return how many were lost."""
        self._refill = True
        lost = 0
        goal = self._received + messages if messages else None
        heard = time.perf_counter()
        end = heard + seconds
        self._fill_window()
        while True:
            before = self._received
            self._executor.spin_once(0.2)
            now = time.perf_counter()
            if self._received != before:
                heard = now
            elif now - heard > SILENCE:
                lost += self._give_up()
                self._fill_window()
                heard = now
            if now > end or (goal is not None and self._received >= goal):
                break
        self._refill = False
        self._settle()
        return lost + self._give_up()

    def _give_up(self) -> int:
        """Return how many are still missing, and expect them no more."""
        missing = self._sent - self._received
        self._sent = self._received
        return missing

    def _fill_window(self) -> None:
        while self._sent - self._received < WINDOW:
            self._send()

    def _at_1khz(self, messages: int, figures: Figures) -> None:
        self._latencies = []
        due = time.perf_counter()
        for _ in range(messages):
            due += PERIOD_NS * 1e-9
            self._spin_until(due)
            data = self._drivers[0].message()
            self._due[_period(data)] = time.perf_counter()
            self._sent += 1
            self._publish[0](data)
        self._settle()
        latencies = sorted(self._latencies)
        figures.p50_us = statistics.median(latencies) * 1e6
        figures.p99_us = latencies[len(latencies) * 99 // 100] * 1e6

    def _settle(self) -> None:
        """Wait for what is under way."""
        end = time.perf_counter() + SILENCE
        while self._received < self._sent and time.perf_counter() < end:
            self._executor.spin_once(0.05)

    def _spin_until(self, end: float) -> None:
        while (left := end - time.perf_counter()) > 0:
            self._executor.spin_once(left)

    def _send(self) -> None:
        turn = self._turn
        self._turn = (turn + 1) % self._robots
        self._sent += 1
        self._publish[turn](self._drivers[turn].message())

    def _count(self, data: bytes) -> None:
        self._received += 1
        if self._refill:
            self._send()
        elif self._due:
            sent = self._due.pop(_period(data), None)
            if sent is not None and self._latencies is not None:
                self._latencies.append(time.perf_counter() - sent)


def _period(data: bytes) -> int:
    """Return in which period of the driver a message is stamped; estimators may remove jitter."""
    seconds, nanoseconds = unpack_from('<iI', data, 4)
    return round((seconds % 1_000_000 * 1_000_000_000 + nanoseconds) / PERIOD_NS)


def _resident_mib(pid: int) -> float:
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 2**20

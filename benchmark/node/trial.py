# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""One node in another process: its start, and what it takes at saturation and at 1 kHz."""
from contextlib import ExitStack
from dataclasses import dataclass
import math
import os
from pathlib import Path
import signal
import statistics
from struct import unpack_from
import subprocess
import time

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from screw_kinematics.node import fast_dds
from screw_kinematics.node.publishers import message_type
from screw_kinematics.pipeline.outputs import KINDS
from sensor_msgs.msg import JointState

from .contenders import Contender
from .robot import Driver, PERIOD_NS
from ..domain import own_domain

WINDOW = 50         # messages under way at most, fewer than any queue holds: nothing is lost
PATIENCE = 60.0     # for a node to start [s]
SILENCE = 5.0       # without any output, after which what is under way counts as lost [s]


@dataclass(frozen=True)
class Saturation:
    """CPU time of the node per message [us], messages per second, and how many were lost."""

    cpu_us: float
    rate: float
    lost: int


@dataclass(frozen=True)
class Latency:
    """CPU time of the node per message [us] at 1 kHz, and the time to its last output [us]."""

    cpu_us: float
    p50_us: float
    p99_us: float


class Trial:
    """
    Drives a node that runs in another process, on a domain of its own.

    Messages are published serialized, and outputs are counted without reading them, so that
    the driving side stays well below the node's own cost. Every sample of every robot is
    expected to lead to each of the outputs; the last one of them is counted.

    Several trials may be open at once: a node that is not driven hardly costs anything.
    """

    def __init__(self, contender: Contender, robots: int) -> None:
        self._contender, self._robots = contender, robots
        self._drivers = [Driver(seed) for seed in range(robots)]
        self._sent = self._received = 0
        self._turn = 0
        self._refill = False
        self._due: dict[int, float] = {}
        self._latencies: list[float] = []
        self.start_s = 0.0      # from the start of the process to its first output

    def __enter__(self) -> 'Trial':
        """Start the node, and make it ready to be timed."""
        with ExitStack() as stack:
            domain = stack.enter_context(own_domain())
            # What is installed has its bytecode, so a checkout shall have it too.
            os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
            # Of the driver alone: contenders have their own settings, or none.
            for variable in fast_dds.FAST_DDS_3.variables:
                os.environ.pop(variable, None)
            environment = dict(os.environ)
            fast_dds.settle()
            self._connect(domain, stack)
            started = time.perf_counter()
            self._process = subprocess.Popen(
                self._contender.command(self._robots), env=environment,
                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            stack.callback(self._stop)
            # CPU time of another process: clock_getcpuclockid(3)
            self._clock = (~self._process.pid << 3) | 2
            self._await_answers(started)
            self._wait_for_compilers()
            self._give_up()
            self._saturate(self._contender.warm_up * self._robots)
            self._close = stack.pop_all().close
        return self

    def __exit__(self, *_: object) -> None:
        """End the node."""
        self._close()

    def saturate(self, seconds: float) -> Saturation:
        """Keep the node busy."""
        received, cpu, begin = self._received, self.cpu_s, time.perf_counter()
        lost = self._saturate(seconds=seconds)
        count = self._received - received
        if not count:
            return Saturation(math.inf, 0.0, lost)
        return Saturation((self.cpu_s - cpu) / count * 1e6,
                          count / (time.perf_counter() - begin), lost)

    def at_1khz(self, seconds: float) -> Latency:
        """Send a sample of the first robot each millisecond."""
        self._latencies.clear()
        self._due.clear()
        cpu = self.cpu_s
        messages = round(seconds * 1000)
        due = time.perf_counter()
        for _ in range(messages):
            due += PERIOD_NS * 1e-9
            self._spin_until(due)
            data = self._drivers[0].message()
            self._due[_period(data)] = time.perf_counter()
            self._sent += 1
            self._publish[0](data)
        self._settle()
        self._due.clear()
        latencies = sorted(self._latencies) or [math.inf]     # nothing came
        return Latency((self.cpu_s - cpu) / messages * 1e6, statistics.median(latencies) * 1e6,
                       latencies[len(latencies) * 99 // 100] * 1e6)

    @property
    def cpu_s(self) -> float:
        """CPU time of the node since it was started [s]."""
        return time.clock_gettime(self._clock)

    @property
    def resident_mib(self) -> float:
        """Resident memory of the node [MiB]."""
        pages = int(Path(f'/proc/{self._process.pid}/statm').read_text().split()[1])
        return pages * os.sysconf('SC_PAGE_SIZE') / 2**20

    def _connect(self, domain: int, stack: ExitStack) -> None:
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=domain)
        stack.callback(context.try_shutdown)
        # The messages to the silent one are never taken: it is there so that the node publishes
        # everything.
        counting, silent = (
            rclpy.create_node(name, context=context, enable_rosout=False)
            for name in ('counting', 'silent'))
        *others, counted = self._contender.outputs
        self._publish = []
        for i in range(self._robots):
            self._publish.append(counting.create_publisher(
                JointState, f'r{i}/joint_states', QoSProfile(depth=100)).publish)
            counting.create_subscription(
                message(counted), f'r{i}/{counted}', self._count, 100, raw=True)
            for output in others:
                silent.create_subscription(
                    message(output), f'r{i}/{output}', lambda _: None, 1, raw=True)
        self._executor = EventsExecutor(context=context)
        self._executor.add_node(counting)
        for node in counting, silent:
            stack.callback(node.destroy_node)
        stack.callback(self._executor.shutdown)

    def _stop(self) -> None:
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(PATIENCE)
        finally:
            self._process.kill()

    def _await_answers(self, started: float) -> None:
        """Send one sample each millisecond, until every robot has answered."""
        while self._received < 20 * self._robots:
            if self._process.poll() is not None or time.perf_counter() - started > PATIENCE:
                self._process.kill()
                assert self._process.stderr is not None
                raise RuntimeError(f'{self._contender.name} does not answer: '
                                   f'{self._process.stderr.read().decode()[-2000:]}')
            self._send()
            self._spin_until(time.perf_counter() + 1e-3 / self._robots)
            if self._received and not self.start_s:
                self.start_s = time.perf_counter() - started

    def _wait_for_compilers(self) -> None:
        """Send nothing until the node rests, as it does once its work in the background ends."""
        end = time.perf_counter() + PATIENCE
        busy = True
        while busy and time.perf_counter() < end:
            cpu = self.cpu_s
            self._spin_until(time.perf_counter() + 0.5)
            busy = self.cpu_s - cpu > 0.02

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
            if sent is not None:
                self._latencies.append(time.perf_counter() - sent)


def message(topic: str) -> type:
    """Return the type of the messages on a topic of a robot."""
    return message_type(KINDS[topic.rpartition('/')[2]].type_name)


def _period(data: bytes) -> int:
    """Return in which period of the driver a message is stamped; estimators may remove jitter."""
    seconds, nanoseconds = unpack_from('<iI', data, 4)
    return round((seconds % 1_000_000 * 1_000_000_000 + nanoseconds) / PERIOD_NS)

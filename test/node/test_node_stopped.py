# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A node that stood still works off the newest messages; the older ones are lost, and told."""
import re
import signal
import time

from geometry_msgs.msg import TwistStamped
import pytest
from support.rig import joint_state, PUMA, running, smooth_motion, stamp_ns

JOINTS = [f'q{k}' for k in range(1, 7)]
PERIOD = 2_000_000
DEPTH = 100


@pytest.mark.parametrize('executor', ['events', 'single_threaded'])
def test_a_stopped_node_works_off_the_newest_and_says_so(context, tmp_path, executor):
    parameters = {
        'robots': ['arm'], 'diagnostics_rate': 10.0, 'executor': executor,
        'arm': {'description': PUMA, 'velocity_source': 'measured', 'outputs': ['twist'],
                'stale_timeout': 60.0},
        'qos_overrides': {
            '/joint_states': {'subscription': {'depth': DEPTH, 'reliability': 'reliable'}},
            '/arm/twist': {'publisher': {'depth': 5000}}}}
    with running(context, tmp_path, parameters) as rig:
        twists = rig.listen('/arm/twist', TwistStamped)
        rig.wait_until_serving('arm', ['twist'])
        publisher, k = rig.publisher('/joint_states'), 0

        def publish(count):
            nonlocal k
            for _ in range(count):
                k += 1
                publisher.publish(joint_state(JOINTS, k * PERIOD, *smooth_motion(6, k * 2e-3)))

        def arrived():
            return bool(twists) and stamp_ns(twists[-1]) == k * PERIOD

        def first():
            publish(1)
            return bool(twists)
        rig.wait(first)     # what was sent before the node was found is lost
        for _ in range(20):
            rig.wait(arrived)
            publish(20)
        rig.wait(arrived)
        before = len(twists)
        rig.process.send_signal(signal.SIGSTOP)
        time.sleep(1.5)
        publish(1000)
        time.sleep(1.5)
        rig.process.send_signal(signal.SIGCONT)
        rig.wait(arrived)
        came = [stamp_ns(twist) // PERIOD for twist in twists]
        assert came == sorted(set(came))
        # The newest, as many as the queue holds; what was under way already may come besides.
        assert came[-DEPTH:] == list(range(k - DEPTH + 1, k + 1)) and len(came) > before
        rig.wait(lambda: 'stood still' in rig.status('node')[2])
        # Once, and whenever the machine stood still besides.
        longest = re.search(r'for ([\d.]+) s', rig.status('node')[2]['stood still'])
        assert longest is not None and float(longest[1]) > 2.5
        assert 'stood still for' in rig.log.read_text()
        # Lost is what lay between stamps that are more than 50 ms apart.
        apart = [b - a for a, b in zip(came, came[1:])]
        lost = sum(steps - 1 for steps in apart if steps * PERIOD > 50_000_000)
        rig.wait(lambda: abs(int(
            rig.status('arm')[2]['lost by their stamps']) - lost) <= 0.1 * lost)

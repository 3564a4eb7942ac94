# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Fast DDS gets the node's settings, or the user's own."""
import os
from pathlib import Path
import subprocess
import sys
import time

from geometry_msgs.msg import TwistStamped
import pytest
from rclpy.utilities import get_rmw_implementation_identifier
from screw_kinematics.node import fast_dds
from support.rig import joint_state, PUMA, running, stamp_ns

JOINTS = tuple(f'q{i}' for i in range(1, 7))
MS = 1_000_000
ROOT = Path(__file__).parents[2]


GENERATIONS = pytest.mark.parametrize('generation', [fast_dds.FAST_DDS_2, fast_dds.FAST_DDS_3],
                                      ids=lambda generation: generation.profile)


@GENERATIONS
def test_it_is_told_where_our_file_is(generation):
    environment = {}
    fast_dds.settle(environment, generation)
    assert [*environment] == [generation.variables[0]]
    assert Path(environment[generation.variables[0]]) == ROOT / 'config' / generation.profile


@GENERATIONS
def test_a_file_of_the_user_is_left_alone(tmp_path, monkeypatch, generation):
    for variable in generation.variables:
        environment = {variable: 'mine.xml'}
        fast_dds.settle(environment, generation)
        assert environment == {variable: 'mine.xml'}

    monkeypatch.chdir(tmp_path)
    (tmp_path / generation.in_working_directory).touch()
    environment = {}
    fast_dds.settle(environment, generation)
    assert environment == {}


def test_fast_dds_takes_its_settings(tmp_path):
    """It tells of what it does not know in its settings, line by line, at every start."""
    code = ('import rclpy; from screw_kinematics.node import fast_dds; fast_dds.settle(); '
            'rclpy.init(); rclpy.create_node("n").create_publisher('
            '__import__("std_msgs.msg").msg.String, "t", 1); rclpy.shutdown()')
    run = subprocess.run([sys.executable, '-c', code], cwd=tmp_path, text=True,
                         capture_output=True, env={**os.environ, 'PYTHONPATH': str(ROOT)})
    assert run.returncode == 0, run.stderr
    assert 'XML' not in run.stdout + run.stderr, run.stdout + run.stderr


def test_without_data_files_the_node_still_starts(tmp_path, monkeypatch):
    monkeypatch.setattr('screw_kinematics.models.uri._SOURCE_TREE', tmp_path)
    monkeypatch.setattr('screw_kinematics.models.uri._pip_prefixes', lambda: [str(tmp_path)])
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    environment = {}
    fast_dds.settle(environment)
    assert environment == {}


def switches(pid):
    """Return how often the thread of Fast DDS's timers was woken."""
    count = 0
    for task in Path(f'/proc/{pid}/task').iterdir():
        if (task / 'comm').read_text().startswith('dds.ev'):
            status = (task / 'status').read_text()
            count += int(status.split('voluntary_ctxt_switches:')[1].split()[0])
    return count


@pytest.mark.skipif(not Path('/proc/self/task').exists(), reason='reads /proc')
def test_messages_do_not_wake_the_timer_thread(context, tmp_path):
    """Each publisher may wake it 50 times per second; by default each message does."""
    if 'fastrtps' not in get_rmw_implementation_identifier():
        pytest.skip('settings of Fast DDS')
    arm = {'description': PUMA, 'outputs': ['twist'], 'velocity_source': 'measured'}
    with running(context, tmp_path, {'robots': ['arm'], 'arm': arm}) as rig:
        twists = rig.listen('arm/twist', TwistStamped)
        rig.wait_until_serving('arm', ['twist'])
        publisher = rig.publisher('joint_states')
        k = 0

        def send():
            nonlocal k
            k += 1
            publisher.publish(joint_state(JOINTS, k * MS, [0.1] * 6, [0.2] * 6))
            return twists
        rig.wait(send)      # the program is made in the background
        before, begin = switches(rig.process.pid), time.monotonic()
        for _ in range(3000):
            send()
            if k % 20 == 0:
                rig.wait(lambda: stamp_ns(twists[-1]) == k * MS)
        count, elapsed = switches(rig.process.pid) - before, time.monotonic() - begin
    assert count < 300 + 75 * elapsed

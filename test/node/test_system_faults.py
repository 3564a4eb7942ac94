# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The node where the system around it is not as it ought to be."""
import os
from pathlib import Path
import shutil
import subprocess

from geometry_msgs.msg import TwistStamped
import numpy as np
import pytest
from screw_kinematics import models
from support import rig as rigs
from support.rig import joint_state, PUMA, running, six, smooth_motion, stamp_ns

JOINTS = [f'q{k}' for k in range(1, 7)]
PARAMETERS = {
    'robots': ['arm'], 'diagnostics_rate': 10.0,
    'arm': {'description': PUMA, 'velocity_source': 'measured', 'outputs': ['twist'],
            'stale_timeout': 60.0, 'estimator': {'max_gap': 0.25}}}


def assert_right_twists(context, directory):
    """Run a node, and compare what it says with the truth."""
    with running(context, directory, PARAMETERS) as rig:
        twists = rig.listen('/arm/twist', TwistStamped)
        rig.wait_until_serving('arm', ['twist'])
        publisher, k = rig.publisher('/joint_states'), 0

        def enough():
            nonlocal k
            k += 1
            publisher.publish(joint_state(JOINTS, k * 10**7, *smooth_motion(6, k * 0.01)))
            return len(twists) > 20
        rig.wait(enough)
        chain = models.load(PUMA)
        for twist in twists:
            expected = chain.state(*smooth_motion(6, stamp_ns(twist) * 1e-9)).classical(1)
            np.testing.assert_allclose(six(twist.twist), expected, atol=1e-9)


@pytest.mark.parametrize('home', ['/dev/null', '/proc/nowhere'])
def test_a_home_where_nothing_can_be_written(context, tmp_path, monkeypatch, home):
    for variable in ('ROS_LOG_DIR', 'ROS_HOME', 'XDG_CACHE_HOME'):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv('HOME', home)
    log = tmp_path / 'log'
    process = rigs.start(['-p', 'robots:=[arm]', '-p', f'arm.description:={PUMA}'], log)
    assert process.wait(60) == 1
    assert len(log.read_text().splitlines()) == 1
    assert 'log directory' in log.read_text() and 'let ROS_LOG_DIR name' in log.read_text()
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'logs'))
    assert_right_twists(context, tmp_path)


@pytest.fixture
def comma_locale(tmp_path, monkeypatch):
    """Set a locale whose decimal point is a comma, made for this test."""
    if shutil.which('localedef') is None:
        pytest.skip('there is no localedef')
    place = tmp_path / 'locales'
    place.mkdir()
    made = subprocess.run(['localedef', '-i', 'de_DE', '-f', 'UTF-8', place / 'de_DE.UTF-8'],
                          capture_output=True, text=True)
    if not (place / 'de_DE.UTF-8' / 'LC_NUMERIC').exists():
        pytest.skip(f'no locale can be made: {made.stderr}')
    monkeypatch.setenv('LOCPATH', str(place))
    monkeypatch.setenv('LC_ALL', 'de_DE.UTF-8')
    monkeypatch.setenv('LANG', 'de_DE.UTF-8')


SETTING = 'import locale; locale.setlocale(locale.LC_ALL, ""); assert locale.str(0.5) == "0,5"; '


def test_decimal_commas(context, tmp_path, monkeypatch, comma_locale):
    """Also where a program has made the locale that of its numbers."""
    monkeypatch.setattr(rigs, 'CODE', SETTING + rigs.CODE)
    assert_right_twists(context, tmp_path)


def without_shared_memory():
    """Return what starts a command with a /dev/shm that nothing can be written to."""
    return ['unshare', '--user', '--map-root-user', '--mount', 'sh', '-c',
            'mount -t tmpfs -o ro none /dev/shm && exec "$@"', 'sh']


def test_no_shared_memory(context, tmp_path, monkeypatch):
    """The middleware falls back to the network."""
    blocked = without_shared_memory()
    if shutil.which('unshare') is None or subprocess.run(
            [*blocked, 'sh', '-c', '! touch /dev/shm/x'], capture_output=True).returncode:
        pytest.skip('no namespace without shared memory can be made here')

    def start(arguments, log):
        import sys
        with open(log, 'w') as file:
            return subprocess.Popen(
                [*blocked, sys.executable, '-c', rigs.CODE, '--ros-args', *arguments],
                stdout=file, stderr=subprocess.STDOUT, env=os.environ)
    monkeypatch.setattr(rigs, 'start', start)
    assert_right_twists(context, tmp_path)
    assert Path('/dev/shm').is_dir()

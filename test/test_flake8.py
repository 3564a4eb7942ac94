# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path
import subprocess
import sys

import pytest

pytest.importorskip('ament_flake8.main', reason='linters come with ROS')
ROOT = Path(__file__).parents[1]


def test_flake8():
    paths = [str(ROOT / p) for p in (
        'screw_kinematics', 'test', 'benchmark', 'doc', 'launch', 'setup.py')]
    # In a process of its own: it forks, which must not meet the threads of a middleware.
    checked = subprocess.run([sys.executable, '-m', 'ament_flake8.main', *paths],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert checked.returncode == 0, checked.stdout

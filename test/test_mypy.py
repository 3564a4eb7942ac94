# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path
import subprocess
import sys

import pytest

pytest.importorskip('mypy')
ROOT = Path(__file__).parents[1]


def test_types():
    run = subprocess.run([sys.executable, '-m', 'mypy', '--config-file', 'setup.cfg',
                          'screw_kinematics', 'benchmark'],
                         cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr

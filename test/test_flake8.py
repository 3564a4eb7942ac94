# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import pytest

ament_flake8 = pytest.importorskip('ament_flake8.main', reason='linters come with ROS')
ROOT = Path(__file__).parents[1]


def test_flake8():
    paths = [str(ROOT / p) for p in ('screw_kinematics', 'test', 'benchmark', 'setup.py')]
    code, errors = ament_flake8.main_with_errors(argv=paths)
    assert code == 0, '\n'.join(errors)

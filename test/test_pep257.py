# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import pytest

ament_pep257 = pytest.importorskip('ament_pep257.main', reason='linters come with ROS')
ROOT = Path(__file__).parents[1]


def test_pep257():
    paths = [str(ROOT / p) for p in (
        'screw_kinematics', 'benchmark', 'test', 'launch', 'setup.py')]
    assert ament_pep257.main(argv=paths) == 0

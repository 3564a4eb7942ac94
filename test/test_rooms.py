# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The rooms of the package stand in one order: each imports those before it, none behind."""
from pathlib import Path
import shutil
import subprocess
import sys

import pytest

pytest.importorskip('importlinter')
ROOT = Path(__file__).parents[1]
LINT = 'import sys; from importlinter.cli import lint_imports_command; lint_imports_command()'


def lint(folder):
    """Hold the package in a folder against the contracts in setup.cfg."""
    return subprocess.run(
        [sys.executable, '-c', LINT, '--config', str(ROOT / 'setup.cfg'), '--no-cache'],
        cwd=folder, env={'PYTHONPATH': str(folder)}, capture_output=True, text=True)


def test_imports_go_down():
    run = lint(ROOT)
    assert run.returncode == 0, run.stdout + run.stderr


def test_an_import_of_a_room_behind_breaks_the_contract(tmp_path):
    shutil.copytree(ROOT / 'screw_kinematics', tmp_path / 'screw_kinematics',
                    ignore=shutil.ignore_patterns('__pycache__'))
    with open(tmp_path / 'screw_kinematics' / 'screws' / 'se3.py', 'a') as file:
        file.write('\nfrom ..motion import smoother    # noqa\n')
    run = lint(tmp_path)
    assert run.returncode == 1
    assert 'screw_kinematics.screws is not allowed to import screw_kinematics.motion' in run.stdout

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What `colcon build` installs is what `ros2 run` looks for."""
import os
from pathlib import Path
import shutil
import subprocess
import sys

import pytest

ROOT = Path(__file__).parents[2]
EXECUTABLES = ('kinematic_state_publisher', 'demo', 'joint_state_source', 'plot', 'derive',
               'bag', 'check')


def colcon():
    """Return the command line of colcon, from this environment or the PATH."""
    beside = Path(sys.executable).with_name('colcon')
    found = str(beside) if beside.exists() else shutil.which('colcon')
    if found is None:
        pytest.skip('colcon is not installed')
    return found


@pytest.fixture(scope='module')
def prefix(tmp_path_factory):
    """Build the package into a fresh workspace and return its install prefix."""
    workspace = tmp_path_factory.mktemp('workspace')
    source = workspace / 'src' / 'screw_kinematics'
    shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(
        '.git', '.venv', 'build', 'install', 'log', '*.egg-info', '__pycache__', '.*_cache'))
    build = subprocess.run(
        [colcon(), 'build', '--packages-select', 'screw_kinematics'], cwd=workspace,
        capture_output=True, text=True,
        env={**os.environ, 'PATH': f'{Path(sys.executable).parent}:{os.environ["PATH"]}'})
    assert build.returncode == 0, build.stdout + build.stderr
    return workspace / 'install' / 'screw_kinematics'


def test_index_marker_leads_to_the_prefix(prefix):
    marker = prefix / 'share/ament_index/resource_index/packages/screw_kinematics'
    assert marker.is_file()
    assert (prefix / 'share/screw_kinematics/package.xml').is_file()


@pytest.mark.parametrize('name', EXECUTABLES)
def test_exactly_one_executable_of_that_name(prefix, name):
    found = [p for p in (prefix / 'lib/screw_kinematics').rglob(name)
             if p.is_file() and os.access(p, os.X_OK)]
    assert len(found) == 1
    assert found[0].read_text().startswith('#!/usr/bin/env python3')


def test_configuration_is_installed(prefix):
    installed = {p.relative_to(prefix / 'share/screw_kinematics')
                 for p in (prefix / 'share/screw_kinematics/config').rglob('*.yaml')}
    shipped = {p.relative_to(ROOT) for p in (ROOT / 'config').rglob('*.yaml')}
    assert shipped and installed == shipped

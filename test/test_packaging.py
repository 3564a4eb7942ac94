# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the package says of itself agrees, and is what its users' tools know."""
from pathlib import Path
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest
import screw_kinematics
import yaml

ROOT = Path(__file__).parents[1]
MANIFEST = ElementTree.parse(ROOT / 'package.xml').getroot()
DEPENDENCIES = {element.text for element in MANIFEST if element.tag.endswith('depend')}
ROS_PACKAGE = re.compile(r'^\s*(?:from|import) (\w+_(?:msgs|interfaces)|rclpy|ament_index_python|'
                         r'launch|launch_ros|domain_coordinator)\b', re.MULTILINE)


def test_keys_are_known_to_rosdep():
    known = yaml.safe_load((ROOT / 'test/rosdep_keys.yaml').read_text())
    assert DEPENDENCIES <= {*known['packages'], *known['system']}, \
        'look the key up in rosdep, then add it to test/rosdep_keys.yaml'


@pytest.mark.parametrize('folder', ['screw_kinematics', 'launch', 'test'])
def test_ros_packages_that_are_imported_are_declared(folder):
    imported = {name for path in (ROOT / folder).rglob('*.py')
                for name in ROS_PACKAGE.findall(path.read_text())}
    assert imported <= DEPENDENCIES


def test_the_version_is_one():
    declared = re.findall(r"version='(\d+\.\d+\.\d+)',", (ROOT / 'setup.py').read_text())
    # catkin_prepare_release raises both, and refuses a setup.py without this very statement.
    assert declared == [MANIFEST.findtext('version')]
    assert screw_kinematics.__version__ == declared[0]


def test_the_changelog_knows_the_version():
    """Either it has a heading, or what it will hold is gathered under 'Forthcoming'."""
    headings = re.findall(r'^(\S.*)\n-+$', (ROOT / 'CHANGELOG.rst').read_text(), re.MULTILINE)
    assert headings
    assert headings[0] == 'Forthcoming' or re.fullmatch(
        re.escape(screw_kinematics.__version__) + r' \(\d{4}-\d\d-\d\d\)', headings[0])


@pytest.mark.parametrize('room', ['errors', 'models', 'motion', 'parallel', 'recordings'])
def test_rooms_are_reached_from_the_package(room):
    run = subprocess.run(
        [sys.executable, '-c', f'import screw_kinematics as s; print(s.{room}.__name__)'],
        cwd=ROOT, capture_output=True, text=True)
    assert run.stdout == f'screw_kinematics.{room}\n', run.stderr
    assert room in dir(screw_kinematics)


def test_an_unknown_name_is_refused():
    with pytest.raises(AttributeError, match="'screw_kinematics' has no attribute 'modles'"):
        screw_kinematics.modles

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The README is short, and what it names exists."""
from pathlib import Path
import re
import subprocess

from screw_kinematics.pipeline.settings import NODE, OUTPUTS, ROBOT

ROOT = Path(__file__).parents[1]
README = (ROOT / 'README.md').read_text(encoding='utf-8')


def table(heading):
    """Return the rows of the table under a heading, as lists of cells."""
    below = README[README.index(heading):]
    lines = below[below.index('\n|'):].strip().split('\n\n')[0].splitlines()
    return [[cell.strip() for cell in line.strip('|').split('|')] for line in lines[2:]]


def test_it_is_short():
    assert len(README.encode()) <= 12_000


def test_ci_finds_the_test_command():
    script = (ROOT / '.ci' / 'run').read_text(encoding='utf-8')
    search = re.search(r'command=\$\((.*)\)', script).group(1)
    command = subprocess.run(['bash', '-c', search], cwd=ROOT, capture_output=True, text=True,
                             check=True).stdout.strip()
    assert re.fullmatch(r"python3 -m venv .* pip install .*'\.\[test\]' .* pytest .*",
                        command.replace('.venv/bin/', ''))


def test_its_parameters_exist():
    names = {s.name for s in NODE} | {f'<robot>.{s.name}' for s in ROBOT}
    cells = [row[0] for row in table('The ten parameters')]
    assert len(cells) == 10
    for cell in cells:
        for name in re.findall(r'`([^`]+)`', cell):
            assert name in names or f'<robot>{name}' in names, name


def test_its_topics_exist():
    topics = [name.removeprefix('<robot>/') for row in table('generate_launch_description')
              if row[0].startswith('`<robot>/') for name in re.findall(r'`([^`]+)`', row[0])]
    assert sorted(topics) == sorted(OUTPUTS)


def test_its_tools_exist():
    for name, _ in table('## Tools'):
        assert (ROOT / 'screw_kinematics' / 'tools' / name.strip('`') / 'main.py').exists()

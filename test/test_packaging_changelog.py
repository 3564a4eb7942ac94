# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A change that a user may notice has a line in the changelog; what CI runs says so."""
from pathlib import Path
import shutil
import subprocess

import pytest

CHECK = Path(__file__).parents[1] / '.ci' / 'changelog'
if shutil.which('git') is None or not CHECK.exists():
    pytest.skip('needs git and a checkout', allow_module_level=True)


@pytest.fixture
def clone(tmp_path):
    """Return a repository with a package, and a function that commits changes to its files."""
    def commit(message, **files):
        for name, text in files.items():
            path = tmp_path / {'code': 'screw_kinematics/a.py', 'test': 'test/test_a.py',
                               'changelog': 'CHANGELOG.rst'}[name]
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        git('add', '-A')
        git('commit', '-qm', message)

    def git(*words):
        subprocess.run(['git', '-c', 'user.name=a', '-c', 'user.email=a@b', *words], cwd=tmp_path,
                       check=True)
    git('init', '-q', '-b', 'main')
    commit('Begin', code='1', test='1', changelog='Forthcoming\n')
    git('checkout', '-q', '-b', 'change')
    return commit


def check(tmp_path):
    return subprocess.run([CHECK, 'main'], cwd=tmp_path, capture_output=True, text=True)


def test_a_change_without_a_line_fails(clone, tmp_path):
    clone('Change', code='2')
    checked = check(tmp_path)
    assert checked.returncode == 1
    assert 'screw_kinematics/a.py' in checked.stdout and 'Forthcoming' in checked.stdout


@pytest.mark.parametrize('commits', [
    [('Change', {'code': '2', 'changelog': 'Forthcoming\n* a\n'})],
    [('Change', {'code': '2'}), ('Tell', {'changelog': 'Forthcoming\n* a\n'})],
    [('Change\n\nChangelog: none', {'code': '2'})],
    [('Test', {'test': '2'})],
])
def test_a_change_that_is_told_or_not_noticed_passes(clone, tmp_path, commits):
    for message, files in commits:
        clone(message, **files)
    checked = check(tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_taking_a_line_away_is_none(clone, tmp_path):
    clone('Change', code='2', changelog='')
    assert check(tmp_path).returncode == 1

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Children end with the context, with the tool's death, and tell why they ended."""
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import pytest

from screw_kinematics.errors import ToolError
from screw_kinematics.tools.processes import Children

STARTS_ONE = """
from screw_kinematics.tools.processes import Children
import sys, time
with Children() as children:
    children.start('sleeper', 'sleeper', [sys.argv[1]])
    time.sleep(600)
"""
SLEEPER = """
import os, pathlib, sys, time
path = pathlib.Path(sys.argv[1])
path.with_suffix('.new').write_text(str(os.getpid()))
path.with_suffix('.new').rename(path)    # so that a reader never sees half of it
time.sleep(600)
"""


@pytest.fixture
def sleeper(tmp_path, monkeypatch):
    """Return the file where a module named sleeper writes its process id."""
    (tmp_path / 'sleeper.py').write_text(SLEEPER)
    inherited = os.environ.get('PYTHONPATH')
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(
        [str(tmp_path), os.getcwd()] + ([inherited] if inherited else [])))
    return tmp_path / 'pid'


def wait_for(condition, limit=30.0):
    """Wait until a condition holds."""
    end = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def is_running(pid):
    """Return whether a process exists and is no zombie."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except FileNotFoundError:
        return False


def test_children_end_with_the_context(sleeper):
    with Children() as children:
        children.start('sleeper', 'sleeper', [str(sleeper)])
        wait_for(sleeper.exists)
        pid = int(sleeper.read_text())
        assert is_running(pid)
    assert not is_running(pid)


def test_children_end_when_the_context_is_left_by_an_error(sleeper):
    with pytest.raises(ZeroDivisionError), Children() as children:
        children.start('sleeper', 'sleeper', [str(sleeper)])
        wait_for(sleeper.exists)
        raise ZeroDivisionError
    assert not is_running(int(sleeper.read_text()))


def test_children_end_when_the_tool_is_killed(sleeper):
    tool = subprocess.Popen([sys.executable, '-c', STARTS_ONE, str(sleeper)])
    try:
        wait_for(sleeper.exists)
        pid = int(sleeper.read_text())
        assert is_running(pid)
        tool.send_signal(signal.SIGKILL)
        tool.wait()
        wait_for(lambda: not is_running(pid))
    finally:
        tool.kill()
        tool.wait()


def test_a_child_that_ended_is_told_with_its_last_words():
    with Children() as children:
        children.start('the calendar', 'calendar', ['--no-such-option'])
        with pytest.raises(ToolError, match='the calendar ended with exit code 2.*--no-such'):
            wait_for(lambda: children.check())

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How the core runs: compiled, interpreted, or compiled from older texts."""
from importlib.machinery import EXTENSION_SUFFIXES
import os
from pathlib import Path
import subprocess
import sys

import pytest
from screw_kinematics import core


@pytest.fixture
def room(tmp_path, monkeypatch):
    """Return a folder in the place of the core, with one module compiled just now."""
    room = tmp_path / 'core'
    room.mkdir()
    for name in ('__init__.py', 'tables.py', 'loops.py', 'loops.pxd',
                 f'loops{EXTENSION_SUFFIXES[0]}'):
        (room / name).touch()
    monkeypatch.setattr(core, '__file__', str(room / '__init__.py'))
    monkeypatch.delenv(core.INTERPRETED, raising=False)
    return room


def test_a_compiled_room_says_so(room):
    assert core.build().compiled
    assert str(core.build()) == 'the core is compiled'


def test_without_binaries_the_texts_run(room):
    (room / f'loops{EXTENSION_SUFFIXES[0]}').unlink()
    assert core.build() == core.Build(('core.loops',), ())
    assert core.build().state == 'interpreted' and 'C compiler' in str(core.build())


@pytest.mark.parametrize('name', ['loops.py', 'loops.pxd'])
def test_an_edited_text_is_noticed(room, name):
    text = room / name
    text.touch()
    later = text.stat().st_mtime + 60
    os.utime(text, (later, later))
    assert core.build() == core.Build((), ('core.loops',))
    assert str(core.build()).startswith('the core is outdated (core.loops changed')


@pytest.mark.parametrize('words', [('screw_kinematics.node.main',), ('screw_kinematics', 'check')])
def test_the_version_says_it_too(words):
    program = subprocess.run(
        [sys.executable, '-m', *words, '--version'], capture_output=True, text=True, check=True,
        env={**os.environ, 'PYTHONPATH': str(Path(core.__file__).parents[2])})
    assert program.stdout.strip().endswith(f'; {core.build()}')


def test_the_environment_chooses_the_texts():
    """Whatever has been compiled, with the variable set all modules are texts."""
    code = ('from importlib import import_module\n'
            'from screw_kinematics import core\n'
            'names = [f"{text.parent.name}.{text.stem}" for text in core.texts()]\n'
            'assert core.build().interpreted == tuple(names)\n'
            'for name in names:\n'
            '    module = import_module(f"screw_kinematics.{name}")\n'
            '    assert module.__file__.endswith(".py"), module.__file__\n')
    root = Path(core.__file__).parents[2]
    subprocess.run([sys.executable, '-c', code], check=True,
                   env={**os.environ, core.INTERPRETED: '1', 'PYTHONPATH': str(root)})


@pytest.mark.skipif(not os.environ.get('SCREW_KINEMATICS_COMPILED'),
                    reason='only where the build is known to have a compiler')
def test_is_compiled():
    assert core.build().compiled, core.build()

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the oldest Cython that is allowed, Ubuntu 24.04's, makes of every text."""
import os
from pathlib import Path
import re
import subprocess
import sys

import pytest
from screw_kinematics import core

ROOT = Path(__file__).parents[2]
OLDEST = re.findall('Cython>=([0-9.]+)', (ROOT / 'pyproject.toml').read_text())[0]

TRANSLATE = """
import gc
import sys
from Cython.Build import cythonize
from setuptools import Extension
gc.disable()        # its trees live long: a third of the time was a search for garbage
cythonize([Extension(name, [path]) for name, path in zip(sys.argv[2::2], sys.argv[3::2])],
          build_dir=sys.argv[1], language_level=3, quiet=True,
          compiler_directives={'emit_code_comments': False})       # nobody reads what is made
"""


def test_it_translates_all_of_them(tmp_path):
    """One that it does not translate leaves the whole package interpreted."""
    pytest.importorskip('pip')
    installed = subprocess.run(
        [sys.executable, '-m', 'pip', 'install', '-q', '--no-deps', '--no-compile', '--target',
         tmp_path / 'old', f'cython=={OLDEST}'], capture_output=True, text=True)
    if installed.returncode:
        pytest.skip(f'Cython {OLDEST} is not to be had: {installed.stderr[-200:]}')
    texts = [text.relative_to(ROOT) for text in core.texts()]
    assert len(texts) > 20
    names = [str(word) for text in texts for word in ('.'.join(text.with_suffix('').parts), text)]
    done = subprocess.run(
        [sys.executable, '-c', TRANSLATE, tmp_path / 'translated', *names], cwd=ROOT,
        env={**os.environ, 'PYTHONPATH': str(tmp_path / 'old')}, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len([*(tmp_path / 'translated').rglob('*.c')]) == len(texts)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The README's examples print what it says, and the tests it names exist."""
import os
from pathlib import Path
import re
import subprocess
import sys

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / 'README.md').read_text(encoding='utf-8')
# A command in one fenced block, what it prints in the next one.
EXAMPLES = re.findall(
    r'^```\n((?:\.venv/bin/python -c|\.venv/bin/derive) .*?)\n```\n```\n(.*?)```$',
    README, flags=re.DOTALL | re.MULTILINE)
NAMED = re.findall(r'`([\w/]*test_\w+\.py)::(test_\w+)`', README)
DERIVE = (f'{sys.executable} -c "import sys; from screw_kinematics.tools.derive.main import main; '
          'sys.exit(main())"')


@pytest.mark.parametrize('command, output', EXAMPLES,
                         ids=[f'example {k + 1}' for k in range(len(EXAMPLES))])
def test_examples_print_what_the_readme_says(command, output):
    command = command.replace('.venv/bin/python', sys.executable)
    command = command.replace('.venv/bin/derive', DERIVE)
    run = subprocess.run(['bash', '-c', command], cwd=ROOT, capture_output=True, text=True,
                         env={**os.environ, 'PYTHONPATH': str(ROOT)})
    assert run.stdout == output, run.stderr


@pytest.mark.parametrize('file, test', NAMED)
def test_named_tests_exist(file, test):
    assert re.search(rf'^def {test}\(', (ROOT / 'test' / file).read_text(), re.MULTILINE)

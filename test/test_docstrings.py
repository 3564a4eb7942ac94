# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Docstrings of public names are complete in the sense of numpydoc."""
from enum import EnumMeta
import importlib
import inspect
import json
import os
from pathlib import Path
import re
import subprocess
import sys

import pytest
from screw_kinematics.errors import MissingExtraError

validate = pytest.importorskip('numpydoc.validate')
ROOT = Path(__file__).parents[1]
MODULES = sorted(
    '.'.join(text.relative_to(ROOT / 'screw_kinematics').with_suffix('').parts)
    .removesuffix('.__init__') for text in (ROOT / 'screw_kinematics').glob('*/*.py')
    if '\n__all__ = [' in text.read_text(encoding='utf-8')) + ['errors']
"""Those that say what is public in them."""

# Style, which flake8 and pep257 settle; sections that are not always of use (See Also, Examples,
# extended summary); and the order of sections.
LEFT_OUT = {'ES01', 'EX01', 'GL01', 'GL02', 'GL03', 'GL07', 'PR08', 'PR09', 'RT02', 'RT04',
            'RT05', 'SA01', 'SA04', 'SS03', 'SS05', 'SS06', 'YD01'}

INTERNAL = {'Graph'}
"""Its methods are called by the scalars it hands out alone."""


def inherited(described, member):
    """Whether a member without a docstring has that of the class it overrides."""
    return not vars(described)[member].__doc__ and any(
        getattr(vars(base).get(member), '__doc__', None) for base in described.__mro__[1:-1])


def public_names(module):
    """Return the paths of a module's public functions and classes, with their members."""
    room = importlib.import_module(f'screw_kinematics.{module}')
    for name in getattr(room, '__all__', [n for n in vars(room) if not n.startswith('_')]):
        described = getattr(room, name)
        if not getattr(described, '__module__', '').startswith(room.__name__) or not (
                inspect.isclass(described) or inspect.isfunction(described)):
            continue
        if name in INTERNAL or isinstance(described, EnumMeta):
            continue
        yield f'{room.__name__}.{name}'
        for member, value in vars(described).items() if inspect.isclass(described) else ():
            if inherited(described, member):
                continue
            if not member.startswith('_') and (inspect.isfunction(value) or isinstance(
                    value, (property, classmethod, staticmethod))):
                yield f'{room.__name__}.{name}.{member}'


def test_what_the_pages_document_is_said_to_be_public_and_is_checked():
    pages = (ROOT / 'doc' / 'reference' / 'library').glob('*.md')
    documented = {name for page in pages for name in re.findall(
        r'automodule:: screw_kinematics\.(\S+)', page.read_text(encoding='utf-8'))}
    assert documented and documented <= set(MODULES)
    for module in documented - {'symbolic'}:
        room = importlib.import_module(f'screw_kinematics.{module}')
        missing = [name for name in room.__all__ if not hasattr(room, name)]
        assert not missing, f'{module}: {missing}'


@pytest.fixture(scope='module')
def findings():
    """Return what numpydoc finds in the texts; compiled classes do not tell their parameters."""
    run = subprocess.run(
        [sys.executable, __file__], capture_output=True, text=True, check=True,
        env=os.environ | {'SCREW_KINEMATICS_INTERPRETED': '1', 'PYTHONPATH': os.pathsep.join(
            [str(ROOT), os.environ.get('PYTHONPATH', '')])})
    return json.loads(run.stdout)


@pytest.mark.parametrize('module', MODULES)
def test_docstrings_are_complete(module, findings):
    if module.startswith('symbolic'):
        pytest.importorskip('sympy')
    assert not findings[module], '\n'.join(findings[module])


def find(module):
    """Return what numpydoc finds in a module, if what it needs is there."""
    try:
        paths = list(public_names(module))
    except MissingExtraError:
        return []
    return [f'{path}: {code} {text}' for path in paths
            for code, text in validate.validate(path)['errors'] if code not in LEFT_OUT]


if __name__ == '__main__':
    print(json.dumps({module: find(module) for module in MODULES}))

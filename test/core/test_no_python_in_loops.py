# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""No call of Python in the loops of the core, by what Cython writes about each line."""
import ast
import re
import subprocess
import sys

import pytest
from screw_kinematics import core

Cython = pytest.importorskip('Cython')

TEXTS = [text for text in core.texts() if text.parent.name == 'core']
# What all modules share is not written into each, as in the build; since Cython 3.2.
SHARED = {'shared_utility_qualified_name': 'screw_kinematics.core._shared'} if tuple(
    map(int, Cython.__version__.split('.')[:2])) >= (3, 2) else {}
LINE = re.compile(r'<pre class="cython line[^>]*>\D*<span class="">(\d+)</span>.*?</pre>'
                  r"(?:\s*<pre class='cython code[^>]*>(.*?)</pre>)?", re.DOTALL)
REFUSALS = re.compile(r'if \(unlikely\([^{}]*?\{[^{}]*\}', re.DOTALL)
# References to objects of the core are counted, which is no call.
COUNTED = '__Pyx_INCREF', '__Pyx_DECREF', '__Pyx_XDECREF'
FUNCTION = re.compile(r'^ *cp?def [^\n=]*?(\w+)\([^)]*\)([\w ]*)$', re.MULTILINE)
CALLS = re.compile(r"<span class='(?:py_c_api|pyx_c_api|pyx_macro_api)'>(\w+)")


@pytest.fixture(scope='module')
def calls(tmp_path_factory):
    """Return what each line of a module calls of Python, but for what only refuses arguments."""
    root, folder = TEXTS[0].parents[2], tmp_path_factory.mktemp('annotated')
    names = {f'screw_kinematics.core.{text.stem}': str(text.relative_to(root)) for text in TEXTS}
    code = ('import gc; gc.disable(); '     # its trees live long
            'from setuptools import Extension; from Cython.Build import cythonize; '
            f'cythonize([Extension(name, [path]) for name, path in {names}.items()], '
            f'build_dir={str(folder)!r}, annotate=True, language_level=3, quiet=True, '
            f'compiler_directives={{"emit_code_comments": False}}, **{SHARED})')
    subprocess.run([sys.executable, '-c', code], check=True, cwd=root, capture_output=True)

    def called(text):
        page = (folder / text.relative_to(root)).with_suffix('.html').read_text(encoding='utf-8')
        return {int(number): [call for call in CALLS.findall(REFUSALS.sub('', code))
                              if call not in COUNTED]
                for number, code in LINE.findall(page)}
    return called


def loops(text):
    """Yield lines of loops where no error can be raised, and of all that runs without the GIL."""
    types = text.with_suffix('.pxd').read_text(encoding='utf-8')
    marks = {name: ending.split() for name, ending in FUNCTION.findall(types)}
    for node in ast.walk(ast.parse(text.read_text(encoding='utf-8'))):
        if isinstance(node, ast.FunctionDef):
            if 'nogil' in marks.get(node.name, ()):
                yield node.name, range(node.body[0].lineno, node.end_lineno + 1)
            elif 'noexcept' in marks.get(node.name, ()):
                for inner in ast.walk(node):
                    if isinstance(inner, (ast.For, ast.While)):
                        yield node.name, range(inner.lineno, inner.end_lineno + 1)
        elif isinstance(node, ast.With) and ast.unparse(node.items[0]) == 'cython.nogil':
            yield 'nogil', range(node.body[0].lineno, node.end_lineno + 1)


LOOPS = {text: found for text in TEXTS if (found := [*loops(text)])}


@pytest.mark.parametrize('text', LOOPS, ids=lambda text: text.stem)
def test_no_line_of_a_loop_calls_python(text, calls):
    found, called = LOOPS[text], calls(text)
    assert len(called) > 30
    python = [f'{name}, line {number}: {called[number]}' for name, lines in found
              for number in lines if called.get(number)]
    assert not python, f'{text.name} calls Python in {python}'


def test_the_loops_are_found():
    """The test itself: all modules but those that only count or compare have loops."""
    assert {text.stem for text in TEXTS if text not in LOOPS} <= {'velocity_trust'}


def test_a_line_that_calls_python_is_found(calls):
    """The test itself: what makes a float of a number calls Python."""
    text = next(text for text in TEXTS if text.stem == 'interpreter')
    lines = text.read_text(encoding='utf-8').splitlines()
    boxed = next(k for k, line in enumerate(lines, start=1) if 'PyFloat_FromDouble(self' in line)
    assert 'PyFloat_FromDouble' in calls(text)[boxed]

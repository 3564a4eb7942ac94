# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages are true: they build without a warning, their Python runs, their links lead on."""
import ast
import doctest
import importlib
from importlib.util import find_spec
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import zlib

import pytest

from screw_kinematics import models
from screw_kinematics.pipeline.parameter_file import read_robots

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / 'doc').rglob('*.md'))
TEXTS = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', ROOT / 'QUALITY_DECLARATION.md', *PAGES]
ROOMS = ('screws', 'programs', 'chains', 'parallel', 'models', 'symbolic', 'motion')
PYTHON = re.compile(r'^```python\n(.*?)^```$', re.DOTALL | re.MULTILINE)
YAML = re.compile(r'^```yaml\n(.*?)^```$', re.DOTALL | re.MULTILINE)
LINK = re.compile(r'(?<!`)\]\(([^)\s`]+)\)')
ROLE = re.compile(r'\{doc\}`(?:[^`<]*<)?([^`>]+)>?`')
TEST = re.compile(r'`([\w/]*test_\w+\.py)::(test_\w+)`')
FILE = re.compile(r'`((?:\w+/)+\w+\.\w+)`')
FENCED = re.compile(r'^```.*?^```$', re.DOTALL | re.MULTILINE)
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE | doctest.IGNORE_EXCEPTION_DETAIL


def name(path):
    """Return a page's path below the root, for the test's name."""
    return str(path.relative_to(ROOT))


def examples(page):
    """Return the page's blocks of Python with the lines they begin at."""
    text = page.read_text(encoding='utf-8')
    return [(text[:found.start(1)].count('\n'), found.group(1))
            for found in PYTHON.finditer(text)]


@pytest.mark.parametrize('page', [p for p in TEXTS if p.exists() and examples(p)], ids=name)
def test_python_on_a_page_runs(page, monkeypatch):
    """One page is one session; blocks without prompts are files or programs: these must parse."""
    monkeypatch.chdir(ROOT)
    names = {}
    for line, code in examples(page):
        if not code.startswith('>>> '):
            ast.parse(code)
            continue
        missing = [m for m in re.findall(r'^(?:>>>|\.\.\.) (?:import|from) (\w+)', code, re.M)
                   if find_spec(m) is None]
        if missing:
            pytest.skip(f'needs {", ".join(missing)}')
        test = doctest.DocTestParser().get_doctest(code, names, name(page), str(page), line)
        reports = []
        result = doctest.DocTestRunner(optionflags=FLAGS).run(
            test, out=reports.append, clear_globs=False)
        names = test.globs
        assert not result.failed, ''.join(reports)


@pytest.mark.parametrize('page', PAGES, ids=name)
def test_model_and_parameter_files_on_a_page_are_accepted(page, tmp_path):
    for number, text in enumerate(YAML.findall(page.read_text(encoding='utf-8'))):
        file = tmp_path / f'{number}.yaml'
        file.write_text(text, encoding='utf-8')
        if text.startswith('name:') and 'limb_1' not in text:   # a limb alone is an excerpt
            models.load(str(file))
        elif '    robots:' in text:
            read_robots(file)


@pytest.mark.parametrize('page', [p for p in TEXTS if p.exists()], ids=name)
def test_links_lead_somewhere(page):
    text = FENCED.sub('', page.read_text(encoding='utf-8'))
    for target in LINK.findall(text):
        if '://' in target or target.startswith('mailto:'):
            continue
        file, _, heading = target.partition('#')
        other = page.parent / file if file else page
        assert other.exists(), f'{name(page)}: {target}'
        if heading:
            assert heading in headings(other), f'{name(page)}: {target}'
    for target in ROLE.findall(text):
        other = (ROOT / 'doc' / target[1:]) if target.startswith('/') else page.parent / target
        assert other.with_suffix('.md').exists(), f'{name(page)}: {{doc}} {target}'


def headings(page):
    """Return the anchors of a page's headings, as GitHub and MyST make them."""
    text = FENCED.sub('', page.read_text(encoding='utf-8'))
    return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-')
            for heading in re.findall(r'^#+ (.*)$', text, re.MULTILINE)}


NAMED = sorted({found for page in TEXTS if page.exists()
                for found in TEST.findall(page.read_text(encoding='utf-8'))})


@pytest.mark.parametrize('file, test', NAMED)
def test_named_tests_exist(file, test):
    assert re.search(rf'^def {test}\(', (ROOT / 'test' / file).read_text(), re.MULTILINE)


@pytest.mark.parametrize('page', ['doc/architecture.md', 'CONTRIBUTING.md'])
def test_files_named_on_a_page_exist(page):
    for file in FILE.findall((ROOT / page).read_text(encoding='utf-8')):
        assert (ROOT / file).exists() or (ROOT / 'screw_kinematics' / file).exists(), file


def test_version_to_cite_is_that_of_the_package():
    cited = re.search(r'^version: (.*)$', (ROOT / 'CITATION.cff').read_text(), re.MULTILINE)
    package = re.search(r'<version>(.*)</version>', (ROOT / 'package.xml').read_text())
    assert cited.group(1) == package.group(1)


def test_reasons_are_all_on_the_page_of_diagnostics():
    from screw_kinematics.errors import Reason
    text = (ROOT / 'doc' / 'reference' / 'diagnostics.md').read_text(encoding='utf-8')
    rows = re.findall(r'^\| `(\w+)` \|', text, re.MULTILINE)
    assert sorted(rows) == sorted(reason.value for reason in Reason)


SPHINX = """
import gc
import sys
from sphinx.cmd.build import main
gc.disable()        # its trees live long: a seventh of the time was a search for garbage
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture(scope='session')
def site(tmp_path_factory):
    """Build the site with warnings as errors, in a copy of what it is made from."""
    for needed in ('sphinx', 'myst_parser', 'numpydoc', 'furo', 'sphinxcontrib.mermaid',
                   'sphinx_copybutton'):
        pytest.importorskip(needed)
    copy = tmp_path_factory.mktemp('site')
    shutil.copytree(ROOT / 'doc', copy / 'doc')
    for file in ('package.xml', 'CHANGELOG.rst', 'CONTRIBUTING.md'):
        shutil.copy(ROOT / file, copy)
    run = subprocess.run(
        [sys.executable, '-c', SPHINX, '-q', '-W', '--keep-going', '-b', 'html',
         str(copy / 'doc'), str(copy / 'html')],
        env={**os.environ, 'PYTHONPATH': str(ROOT)}, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return copy / 'html'


def test_site_builds_without_a_warning(site):
    assert (site / 'index.html').exists()


def test_public_names_are_in_the_reference(site):
    """What a room hands on is documented."""
    # Four lines of heading, then one for each object that begins with its name.
    inventory = zlib.decompress((site / 'objects.inv').read_bytes().split(b'\n', 4)[4])
    known = {line.split()[0] for line in inventory.decode().splitlines()}
    for room in ROOMS:
        module = importlib.import_module(f'screw_kinematics.{room}')
        described = [public for public in module.__all__ if getattr(module, public).__doc__
                     and not isinstance(getattr(module, public), (dict, tuple))]
        missing = [public for public in described
                   if f'screw_kinematics.{room}.{public}' not in known]
        assert not missing, f'{room}: {missing} are not in doc/reference/library'
    # What classes inherit, too.
    assert {'screw_kinematics.chains.SerialChain.inverse_velocity',
            'screw_kinematics.parallel.ParallelManipulator.dof'} <= known

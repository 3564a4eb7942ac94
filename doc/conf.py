# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the documentation: ``sphinx-build -W -b html doc build/doc`` at the root."""
from importlib.util import find_spec
from pathlib import Path
import sys
from typing import Any
from urllib.request import urlopen
import xml.etree.ElementTree as ElementTree

from sphinx.util.nodes import make_refnode

HERE = Path(__file__).resolve().parent
# Extensions of this folder, and the package of this checkout before any installed one.
sys.path[:0] = [str(HERE / '_extensions'), str(HERE.parent)]


def version_of_package() -> str:
    """Return the version in package.xml, which a copy of this folder alone lacks."""
    try:
        return ElementTree.parse(HERE.parent / 'package.xml').findtext('version', '')
    except OSError:
        return ''


def reachable(inventories: dict[str, str]) -> dict[str, tuple[str, None]]:
    """Return those sites that answer: without a network pages are built without their links."""
    found: dict[str, tuple[str, None]] = {}
    for name, site in inventories.items():
        try:
            with urlopen(f'{site}/objects.inv', timeout=3):
                found[name] = (site, None)
        except OSError:
            continue
    return found


def sections_as_rubrics(app: Any, what: str, name: str, described: Any, options: Any,
                        lines: list[str]) -> None:
    """Turn the headings in a module's docstring into rubrics: a page has several modules."""
    for k in range(len(lines) - 1, 0, -1):
        if what == 'module' and lines[k - 1].strip() and set(lines[k]) == {'-'}:
            lines[k - 1:k + 1] = [f'.. rubric:: {lines[k - 1]}', '']


def handed_on(app: Any, environment: Any, reference: Any, contents: Any) -> Any:
    """Resolve a name by the file it is written in to the same one where its room hands it on."""
    domain = environment.get_domain('py')
    name = reference.get('reftarget', '').rpartition('.')[2]
    known = {full for full in domain.objects if full.rpartition('.')[2] == name}
    if reference.get('refdomain') != 'py' or len(known) != 1:
        return None
    full = known.pop()
    return make_refnode(app.builder, reference['refdoc'], domain.objects[full].docname,
                        domain.objects[full].node_id, contents, full)


def setup(app: Any) -> None:
    """Connect what is above."""
    app.connect('autodoc-process-docstring', sections_as_rubrics)
    app.connect('missing-reference', handed_on)


project = 'screw_kinematics'
author = 'screw_kinematics contributors'
copyright = author      # noqa: A001 - Sphinx asks for it by this name
release = version = version_of_package()

extensions = [
    'myst_parser', 'numpydoc', 'sphinx.ext.autodoc', 'sphinx.ext.autosummary',
    'sphinx.ext.intersphinx', 'sphinx.ext.mathjax', 'sphinxcontrib.mermaid',
    'sphinx_copybutton', 'from_the_code']
nitpicky = True
# Types in signatures are for reading; references in text must resolve.
nitpick_ignore_regex = [('py:(class|exc|obj|data)', '.*')]
intersphinx_mapping = reachable({
    'python': 'https://docs.python.org/3', 'numpy': 'https://numpy.org/doc/stable',
    'sympy': 'https://docs.sympy.org/latest'})

myst_enable_extensions = ['dollarmath', 'deflist', 'colon_fence', 'attrs_inline']
myst_heading_anchors = 4
myst_fence_as_directive = ['mermaid']

autodoc_member_order = 'bysource'
autodoc_typehints = 'none'              # the docstrings give types with shapes and units
autodoc_mock_imports = [
    room for room in ('rclpy', 'sympy') if find_spec(room) is None]
autosummary_generate = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

# Diagrams are text, drawn in the reader's browser: by mermaid's files in _static/mermaid if they
# are there (npm pack mermaid, its folder dist), else from the network.
if (HERE / '_static' / 'mermaid' / 'mermaid.esm.min.mjs').exists():
    mermaid_use_local = 'mermaid/mermaid.esm.min.mjs'

mermaid_height = 'auto'
mermaid_fullscreen = False

html_theme = 'furo'
html_title = 'screw_kinematics'
html_static_path = ['_static']
html_css_files = ['pages.css']
html_show_sphinx = False
copybutton_prompt_text = r'>>> |\.\.\. |\$ '
copybutton_prompt_is_regexp = True
exclude_patterns = ['_extensions']
if not (HERE.parent / 'CHANGELOG.rst').exists():    # as where rosdoc2 builds, which has its own
    exclude_patterns += ['changelog.md', 'contributing.md']
rosdoc2_settings = {'allow_other_extensions': True}

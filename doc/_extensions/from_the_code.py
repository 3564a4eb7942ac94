# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Directives that print what the code says of itself, so that pages cannot fall behind it."""
from __future__ import annotations

from collections.abc import Iterable
from contextlib import redirect_stdout, suppress
import importlib
from io import StringIO
import os
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from screw_kinematics.pipeline.setting import Setting
from screw_kinematics.pipeline.settings import NODE, ROBOT

WHEN = {'': 'at any time', 'configured': 'while unconfigured', 'started': 'at start only'}


class Help(SphinxDirective):
    """What a console program prints for ``--help``; arguments: its module, and words before."""

    required_arguments = 1
    optional_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the help as a block of text."""
        program = importlib.import_module(f'screw_kinematics.{self.arguments[0]}')
        printed = StringIO()
        os.environ['COLUMNS'] = '79'        # as argparse asks for it
        with redirect_stdout(printed), suppress(SystemExit):
            program.main([*self.arguments[1:], '--help'])
        block = nodes.literal_block(printed.getvalue(), printed.getvalue())
        block['language'] = 'text'
        return [block]


class Parameters(SphinxDirective):
    """The parameters of the ``node`` or of each ``robot``, one definition each."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the definitions, read as Markdown."""
        settings, prefix = {'node': (NODE, ''), 'robot': (ROBOT, '<robot>.')}[self.arguments[0]]
        lines = [line for setting in settings for line in definition(setting, prefix)]
        place = nodes.container()
        self.state.nested_parse(StringList(lines, source='settings'), self.content_offset, place)
        return place.children


def definition(setting: Setting, prefix: str) -> Iterable[str]:
    """Yield the lines that tell one setting's name, default, meaning and values."""
    yield f'`{prefix}{setting.name}`'
    yield f': {setting.text}'.replace('<', r'\<')
    yield ''
    yield (f'  *Default* {shown(setting.default)}. *Allowed*: {setting.allowed}. '
           f'*Changes* {WHEN[setting.fixed]}.')
    yield ''


def shown(value: Any) -> str:
    """Return a default as one writes it in a parameter file."""
    if value in ('', ['']):
        return 'empty'
    if isinstance(value, list):
        return f'`[{", ".join(map(str, value))}]`'
    return f'`{str(value).lower() if isinstance(value, bool) else value}`'


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directives."""
    app.add_directive('parameters', Parameters)
    app.add_directive('help', Help)
    return {'parallel_read_safe': True}

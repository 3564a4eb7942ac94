# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
YAML from anybody, read without surprises.

Only lists, mappings and text: tags and aliases are refused, so nothing is constructed
and nothing grows when it is expanded; size and nesting are bounded; a key given twice is
an error and not, as usual, the last one's silent victory. Scalars stay text, for whoever
knows what a field means to convert them: so a joint may be called ``on`` or ``1``, and
1e-3 is the number it looks like (YAML 1.1 takes the one for a truth value and the other
for text).
"""
from __future__ import annotations

from typing import Any

import yaml

from .fields import shown
from ..errors import ModelError

MAX_BYTES = 50_000
MAX_DEPTH = 20


class _Loader(yaml.BaseLoader):
    """PyYAML's plainest loader with less freedom."""

    depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event: Any = self.peek_event()      # type: ignore[no-untyped-call]
        if isinstance(event, yaml.AliasEvent):
            raise _refusal(event, f'alias *{event.anchor}; allowed: values written out')
        if getattr(event, 'tag', None) is not None:
            raise _refusal(event, f'tag {shown(event.tag)}; allowed: plain values')
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise _refusal(event, f'nested deeper than {MAX_DEPTH}')
        node = super().compose_node(parent, index)      # type: ignore[no-untyped-call]
        self.depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise _refusal(key, 'key that is a collection; allowed: text')
            if key.value in seen:
                raise _refusal(key, f'key {shown(key.value)} is given twice')
            seen.add(key.value)
        mapping: dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


def _refusal(mark: Any, problem: str) -> yaml.MarkedYAMLError:
    return yaml.MarkedYAMLError(problem=problem, problem_mark=mark.start_mark)


def read_yaml(source: str, text: str | bytes) -> Any:
    """
    Return the data of a YAML document: mappings and lists, down to text; None if it is empty.

    Raises
    ------
    ModelError
        Not YAML, too large, too deeply nested, or with tags, aliases or double keys; the
        message names the line.

    Examples
    --------
    >>> read_yaml('doc', 'axis: [0, 0, 1]')
    {'axis': ['0', '0', '1']}

    """
    if len(text) > MAX_BYTES:
        raise ModelError(source, f'more than {MAX_BYTES} bytes; allowed: at most that')
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        line = f'line {error.problem_mark.line + 1}: ' if error.problem_mark else ''
        raise ModelError(source, f'{line}{error.problem}') from None
    except yaml.YAMLError as error:
        raise ModelError(source, f'not YAML: {error}') from None

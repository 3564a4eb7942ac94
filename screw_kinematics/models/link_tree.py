# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The links of a description as a tree, and the path between two of them."""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from .fields import listed, nearest
from ..errors import ModelError


@dataclass(frozen=True)
class Edge:
    """A joint as the connection of two links, both given by name."""

    joint: str
    parent: str
    child: str


class LinkTree:
    """
    Links connected by joints; every step of the work is linear in their number.

    Raises
    ------
    ModelError
        The links do not form one tree: a name is given twice or not at all, a link has
        two parents, there are several roots, or a cycle.

    Examples
    --------
    >>> tree = LinkTree('doc', ['a', 'b', 'c'], [Edge('j', 'a', 'b'), Edge('k', 'a', 'c')])
    >>> tree.root, tree.leaves('a')
    ('a', ['b', 'c'])
    >>> [(edge.joint, downwards) for edge, downwards in tree.path('b', 'c')]
    [('j', False), ('k', True)]

    """

    def __init__(self, source: str, links: Iterable[str], edges: Iterable[Edge]) -> None:
        self._source = source
        self._children: dict[str, list[str]] = {}
        for link in links:
            if link in self._children:
                raise self._error(f'link {link!r} is defined twice')
            self._children[link] = []
        self._above: dict[str, Edge] = {}
        self._children_by_joint: dict[str, str] = {}
        for edge in edges:
            if edge.joint in self._children_by_joint:
                raise self._error(f'joint {edge.joint!r} is defined twice')
            self._children_by_joint[edge.joint] = edge.child
            for role, link in (('parent', edge.parent), ('child', edge.child)):
                if link not in self._children:
                    raise self._error(f'joint {edge.joint!r}: {role}: got {link!r}; '
                                      f'allowed: a link ({listed(self._children, near=link)})')
            if edge.child in self._above:
                raise self._error(
                    f'link {edge.child!r} is the child of two joints, '
                    f'{self._above[edge.child].joint!r} and {edge.joint!r}; allowed: one')
            self._above[edge.child] = edge
            self._children[edge.parent].append(edge.child)
        self.root = self._only_root()

    def below(self, top: str) -> list[str]:
        """Return a link and all below it, in the order of the document."""
        found = self._below(self.link('base frame', top))
        return [link for link in self._children if link in found]

    def leaves(self, top: str) -> list[str]:
        """Return the links without children below a link, in the order of the document."""
        return [link for link in self.below(top) if not self._children[link]]

    def link(self, role: str, name: str) -> str:
        """Return a link's name, after checking that it exists."""
        if name in self._children:
            return name
        child = self._children_by_joint.get(name)
        near = nearest(name, self._children)
        hint = f', a joint; did you mean its child link {child!r}?' if child is not None else (
            f'; did you mean {near[0]!r}?' if near else ';')
        raise self._error(f'{role}: got {name!r}{hint} allowed: a link '
                          f'({listed(self._children, near=child or name)})')

    def path(self, base: str, tip: str) -> list[tuple[Edge, bool]]:
        """
        Return the edges from base to tip, each with whether it is passed from parent to child.

        The path goes up from the base to the lowest common ancestor, and from there down.
        """
        up = self._upwards(self.link('base frame', base))
        down = self._upwards(self.link('tip frame', tip))
        while up and down and up[-1] is down[-1]:
            up.pop()
            down.pop()
        return [(edge, False) for edge in up] + [(edge, True) for edge in reversed(down)]

    def _error(self, problem: str) -> ModelError:
        return ModelError(self._source, problem)

    def _upwards(self, link: str) -> list[Edge]:
        edges = []
        while link in self._above:
            edges.append(self._above[link])
            link = edges[-1].parent
        return edges

    def _below(self, top: str) -> set[str]:
        found, waiting = {top}, [top]
        while waiting:
            children = self._children[waiting.pop()]
            found.update(children)
            waiting.extend(children)
        return found

    def _only_root(self) -> str:
        if not self._children:
            raise self._error('no links; allowed: at least two links and a joint')
        roots = [link for link in self._children if link not in self._above]
        if len(roots) > 1:
            raise self._error(f'several root links: {listed(roots)}; allowed: one')
        # Each link has at most one parent, so what no root reaches runs in a circle.
        reached = self._below(roots[0]) if roots else set()
        if len(reached) < len(self._children):
            circle = [link for link in self._children if link not in reached]
            raise self._error(f'joints form a cycle through links {listed(circle)}')
        return roots[0]

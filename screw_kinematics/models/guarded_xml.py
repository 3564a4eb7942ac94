# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Guarded reading of robot XML: the links and joints of a document and nothing else.

A robot description may come from anybody on the network. So a document type, and with it
every entity, is refused; nothing outside the text is fetched; size and nesting are
bounded. What is not a link or a joint (geometry, transmissions, simulator tags) is
passed over and not kept.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from xml.parsers import expat

from .fields import MAX_TEXT
from ..errors import ModelError

# Far beyond any robot, and so little that what is refused is refused within a second.
MAX_BYTES = 4_000_000
MAX_ELEMENTS = 100_000
MAX_DEPTH = 50

_KINEMATIC = ('parent', 'child', 'origin', 'axis', 'mimic', 'limit')


@dataclass
class JointElement:
    """A joint as written: its attributes, and those of its parts by tag (first of each)."""

    attributes: dict[str, str]
    parts: dict[str, dict[str, str]] = field(default_factory=dict)


@dataclass
class RobotDocument:
    """The name, the links' names and the joints of a robot, in the document's order."""

    name: str = ''
    links: list[str | None] = field(default_factory=list)
    joints: list[JointElement] = field(default_factory=list)


class _Reader:
    """Handlers of the parser's events; ``depth`` counts the open elements."""

    def __init__(self, document: RobotDocument) -> None:
        self.document = document
        self.depth = 0
        self.elements = 0
        self.joint: JointElement | None = None

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        self.elements += 1
        if self.elements > MAX_ELEMENTS:
            raise ValueError(f'more than {MAX_ELEMENTS} elements; allowed: at most that')
        if self.depth == 1:
            if tag != 'robot':
                raise ValueError(f"root element: got {tag[:80]!r}; allowed: 'robot'")
            self.document.name = attributes.get('name', '')[:MAX_TEXT]
        elif self.depth == 2:
            if tag.startswith('xacro:'):
                raise ValueError(f'got the macro element {tag[:80]!r}; allowed: URDF '
                                 'expanded by xacro, or a file with the ending .xacro')
            self.joint = None
            if tag == 'link':
                self.document.links.append(attributes.get('name'))
            elif tag == 'joint':
                self.joint = JointElement(attributes)
                self.document.joints.append(self.joint)
        elif self.depth == 3 and self.joint is not None and tag in _KINEMATIC:
            self.joint.parts.setdefault(tag, attributes)
        elif self.depth > MAX_DEPTH:
            raise ValueError(f'elements nested deeper than {MAX_DEPTH}')

    def end(self, _tag: str) -> None:
        self.depth -= 1

    def doctype(self, name: str, *_: object) -> None:
        raise ValueError(f'document type {name[:80]!r}; allowed: none (entities are refused)')


def read_document(source: str, text: str | bytes) -> RobotDocument:
    """
    Return the links and joints of a robot document.

    Parameters
    ----------
    source : str
        File or topic, for messages.
    text : str or bytes
        The XML document; bytes where it declares its own encoding.

    Raises
    ------
    ModelError
        Not well-formed, no robot, too large, too deeply nested, with a document type or
        with macros; the message names the line.

    Examples
    --------
    >>> read_document('doc', '<robot name="r"><link name="a"/><gazebo/></robot>').links
    ['a']

    """
    if len(text) > MAX_BYTES:
        raise ModelError(source, f'more than {MAX_BYTES} bytes; allowed: at most that')
    document = RobotDocument()
    reader = _Reader(document)
    parser = expat.ParserCreate()
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.StartDoctypeDeclHandler = reader.doctype
    try:
        # A declaration must come first in XML; other readers of URDF allow blanks before it.
        parser.Parse(text.lstrip(), True)
    except expat.ExpatError as error:
        raise ModelError(source, f'not well-formed XML: {error}') from None
    except ValueError as error:     # from the handlers, or text that is not Unicode
        raise ModelError(source, f'line {parser.CurrentLineNumber}: {error}') from None
    return document

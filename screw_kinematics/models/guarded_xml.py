# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Guarded reading of robot XML: the links and joints of a document and little else.

A robot description may come from anybody on the network. So a document type, and with it
every entity, is refused; nothing outside the text is fetched; size and nesting are
bounded. What is no link or joint is passed over: in silence where it is known to have no
part in the kinematics (geometry, transmissions, simulators' tags), else it is noted with its
line, so that whoever builds a chain can say what is not in it.
"""
from __future__ import annotations

import codecs
from collections.abc import Callable
from dataclasses import dataclass, field
from difflib import get_close_matches
import re
from xml.parsers import expat

from .fields import MAX_TEXT, shown
from ..errors import ModelError

# Far beyond any robot, and so little that what is refused is refused within a second.
MAX_BYTES = 4_000_000
MAX_ELEMENTS = 100_000
MAX_DEPTH = 50
_NOTED = 10     # kinds of foreign elements that are kept

_KINEMATIC = ('parent', 'child', 'origin', 'axis', 'mimic', 'limit')
_WITHOUT_KINEMATICS = frozenset(('material', 'transmission', 'gazebo', 'ros2_control', 'sensor',
                                 'mujoco'))
_OF_JOINTS_WITHOUT_KINEMATICS = frozenset((
    'dynamics', 'calibration', 'safety_controller', 'hardwareInterface', 'gazebo', 'sensor',
    'dont_collapse', 'disable_fixed_joint_lumping', 'implicitSpringDamper', 'material'))
# Geometry in other formats, which somebody may have meant to be read.
_OTHER_GEOMETRY = frozenset(('axis2', 'pose', 'thread_pitch', 'screw_thread_pitch', 'frame',
                             'transform', 'rotation', 'translation', 'quaternion',
                             'position', 'orientation', 'offset', 'xyz', 'rpy', 'pitch'))
# Of xacro before it had a prefix; in a joint each of them may stand for anything.
_OLD_MACROS = frozenset(('include', 'insert_block', 'if', 'unless', 'macro', 'property', 'call'))
_NO_TEXT = frozenset(('idna', 'punycode', 'unicode-escape', 'unicode_escape',
                      'raw-unicode-escape', 'raw_unicode_escape', 'undefined'))
# Longest first: the mark of UTF-16 begins that of UTF-32.
_MARKS = ((codecs.BOM_UTF32_LE, 'utf-32'), (codecs.BOM_UTF32_BE, 'utf-32'),
          (codecs.BOM_UTF16_LE, 'utf-16'), (codecs.BOM_UTF16_BE, 'utf-16'),
          (codecs.BOM_UTF8, 'utf-8-sig'), (b'<\0', 'utf-16-le'), (b'\0<', 'utf-16-be'))
_DECLARATION = re.compile(rb'\s*<\?xml[^>]*?\sencoding\s*=\s*["\']([^"\'>]*)["\']')


@dataclass(slots=True)
class JointElement:
    """
    A joint as written: its attributes, and those of its parts by tag (first of each).

    ``stranger`` is a part of unknown meaning that may change the joint, in words, its line, and
    what was likely meant.
    """

    attributes: dict[str, str]
    line: int
    parts: dict[str, dict[str, str]] = field(default_factory=dict)
    stranger: tuple[str, int, str] | None = None


@dataclass(slots=True)
class ForeignElement:
    """An element that was passed over: its tag, its first line, and what it may stand for."""

    tag: str
    line: int
    macro: bool
    holds_joints: bool = False


@dataclass(slots=True)
class RobotDocument:
    """The name, the links' names and the joints of a robot, in the document's order."""

    name: str = ''
    version: str = '1.0'
    links: list[str | None] = field(default_factory=list)
    joints: list[JointElement] = field(default_factory=list)
    foreign: dict[str, ForeignElement] = field(default_factory=dict)


class _Reader:
    """Handlers of the parser's events; ``depth`` counts the open elements."""

    def __init__(self, line: Callable[[], int]) -> None:
        self.document = RobotDocument()
        self._line = line
        self._depth = 0
        self._tag = ''
        self._elements = 0
        self._macros = {'xacro'}    # prefixes
        self._joint: JointElement | None = None
        self._foreign: ForeignElement | None = None

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        self._tag = tag
        self._elements += 1
        if self._elements > MAX_ELEMENTS:
            raise ValueError(f'more than {MAX_ELEMENTS} elements; allowed: at most that')
        if self._depth > MAX_DEPTH:
            raise ValueError(f'elements nested deeper than {MAX_DEPTH}')
        if self._depth == 1:
            self._root(tag, attributes)
        elif self._depth == 2:
            self._child_of_robot(tag, attributes)
        elif self._joint is not None:
            self._part_of_joint(self._joint, tag, attributes)
        elif self._foreign is not None:
            self._foreign.holds_joints |= tag in ('link', 'joint') or tag == 'child'
        elif self._is_macro(tag):
            self._note(tag)

    def end(self, _tag: str) -> None:
        self._depth -= 1

    def doctype(self, name: str, *_: object) -> None:
        raise ValueError(f'document type {name[:80]!r}; allowed: none (entities are refused)')

    def _root(self, tag: str, attributes: dict[str, str]) -> None:
        if tag != 'robot':
            raise ValueError(f"root element: got {tag[:80]!r}; allowed: 'robot'")
        self.document.name = attributes.get('name', '')[:MAX_TEXT]
        self.document.version = attributes.get('version', '1.0')[:MAX_TEXT]
        self._macros |= {key[len('xmlns:'):] for key, value in attributes.items()
                         if key.startswith('xmlns:') and 'xacro' in value}

    def _child_of_robot(self, tag: str, attributes: dict[str, str]) -> None:
        self._joint = self._foreign = None
        if tag == 'link':
            self.document.links.append(attributes.get('name'))
        elif tag == 'joint':
            self._joint = JointElement(attributes, self._line())
            self.document.joints.append(self._joint)
        elif tag not in _WITHOUT_KINEMATICS:
            self._foreign = self._note(tag)

    def _part_of_joint(self, joint: JointElement, tag: str, attributes: dict[str, str]) -> None:
        if self._depth == 3 and tag in _KINEMATIC:
            if joint.parts.setdefault(tag, attributes) is not attributes:
                self._note(f'{tag} (a second one)')     # as other readers of URDF have it
            return
        if self._is_macro(tag) or self._depth == 3 and _may_change_a_joint(tag):
            meant = meant_part(tag)
            self._meet(joint, f'the element {tag[:80]!r}',
                       '' if meant is None else f'did you mean {meant!r}?')
        elif self._depth == 3 and tag not in _OF_JOINTS_WITHOUT_KINEMATICS:
            self._note(tag)

    def text(self, data: str) -> None:
        joint, said = self._joint, data.strip()
        if said and joint is not None and self._depth == 3 and self._tag in _KINEMATIC:
            self._meet(joint, f'the text {said[:80]!r} in {self._tag!r}', 'allowed: attributes')

    def _meet(self, joint: JointElement, what: str, meant: str) -> None:
        joint.stranger = joint.stranger or (what, self._line(), meant)

    def _is_macro(self, tag: str) -> bool:
        return tag.partition(':')[0] in self._macros and ':' in tag

    def _note(self, tag: str) -> ForeignElement:
        """Return the note of a tag, kept if there are not too many."""
        foreign = self.document.foreign
        if tag in foreign:
            return foreign[tag]
        note = ForeignElement(tag, self._line(), self._is_macro(tag))
        if len(foreign) < _NOTED:
            foreign[tag] = note
        return note


def _may_change_a_joint(tag: str) -> bool:
    local = tag.rpartition(':')[2]
    return (local in _OLD_MACROS or local in _OTHER_GEOMETRY or local in _KINEMATIC[:-1]
            or meant_part(tag) is not None and local not in _OF_JOINTS_WITHOUT_KINEMATICS)


def meant_part(tag: str) -> str | None:
    """
    Return the part of a joint that a misspelt tag was likely meant to be.

    Examples
    --------
    >>> meant_part('orgin'), meant_part('Axis'), meant_part('dynamics')
    ('origin', 'axis', None)

    """
    return next(iter(get_close_matches(tag.lower(), _KINEMATIC[:-1], 1, 0.75)), None)


def read_document(source: str, text: str | bytes) -> RobotDocument:
    """
    Return the links and joints of a robot document; bytes where it declares its own encoding.

    Raises
    ------
    ModelError
        Not well-formed, no robot, too large, too deeply nested, or with a document type;
        the message names the line.

    Examples
    --------
    >>> read_document('doc', '<robot name="r"><link name="a"/><gazebo/></robot>').links
    ['a']

    """
    if len(text) > MAX_BYTES:
        raise ModelError(source, f'more than {MAX_BYTES} bytes; allowed: at most that')
    text = _decoded(source, text) if isinstance(text, bytes) else text
    # A declaration must come first in XML; other readers of URDF allow blanks before it.
    document = text.lstrip('\ufeff \t\r\n')
    skipped = text[:len(text) - len(document)].count('\n')
    parser = expat.ParserCreate()
    reader = _Reader(lambda: parser.CurrentLineNumber + skipped)
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.StartDoctypeDeclHandler = reader.doctype
    parser.CharacterDataHandler = reader.text
    try:
        parser.Parse(document, True)
    except expat.ExpatError as error:
        raise ModelError(source, f'not well-formed XML: {expat.ErrorString(error.code)}: line '
                         f'{error.lineno + skipped}, column {error.offset}') from None
    except ValueError as error:     # from the handlers, or text that is not Unicode
        raise ModelError(source,
                         f'line {parser.CurrentLineNumber + skipped}: {error}') from None
    return reader.document


def _decoded(source: str, data: bytes) -> str:
    """Return a file's text, in the encoding of its mark or of its declaration."""
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), None)
    if encoding is None:
        declared = _DECLARATION.match(data)
        encoding = 'utf-8' if declared is None else _known(source, declared[1].decode('latin-1'))
        if data.isascii() and b'\0' not in data:
            encoding = 'ascii'      # whatever it declares
    try:
        return data.decode(encoding)
    except UnicodeError as error:
        raise ModelError(source, f'not {encoding}: {error}') from None


def _known(source: str, name: str) -> str:
    """Return the encoding of a name, if it is one of text."""
    try:
        found = codecs.lookup(name)
        if found.name not in _NO_TEXT and 'x'.encode(found.name):
            return found.name
    except (LookupError, UnicodeError, ValueError):     # unknown, or no encoding of text
        pass
    raise ModelError(source, f'encoding: got {shown(name)}; allowed: one of text, such as '
                     "'utf-8' or 'iso-8859-1'")

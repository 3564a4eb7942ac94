# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Chains from URDF.

Read directly, not with a general parser: a chain needs a few tags, and the general ones
resolve entities, print to the terminal, or stop at tags that are none of their business.
Only the joints between base and tip, and those they follow, are read in full, so a
defect elsewhere in a description does not stop an arm. What these joints say is read to the
last attribute: nothing that may change the geometry is passed over.

References
----------
URDF specification, http://wiki.ros.org/urdf/XML/joint

"""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf, sqrt
import re

import numpy as np

from .fields import Fields, listed, number, reported
from .guarded_xml import JointElement, read_document, RobotDocument
from .joint_entries import MAX_JOINTS, resolve_mimic
from .link_tree import Edge, LinkTree
from ..chains.joint import Joint, Mimic
from ..chains.serial_chain import SerialChain
from ..errors import ModelError
from ..screws.rotations import pose, rotation_from_quaternion, rotation_rpy
from ..screws.se3 import Array, inverse

_MOVING = ('revolute', 'continuous', 'prismatic')
_KINDS = ('fixed', *_MOVING)
_FREE = ('floating', 'planar')
_EXPANDED = 'allowed: URDF expanded by xacro, or a file with the ending .xacro'
# Names of the frame at the end of an arm, the most certain first.
_TIPS = ('tool0', 'tcp', 'flange', 'hand', 'tool', 'gripper', r'(?<![a-z])ee(?![a-z])')


@np.errstate(over='ignore', invalid='ignore')    # what overflows is refused as not finite
def load_urdf(text: str | bytes, base_frame: str | None = None, tip_frame: str | None = None,
              source: str = 'robot_description', warnings: Sequence[str] = ()) -> SerialChain:
    """
    Return the chain between two links of a URDF text.

    Parameters
    ----------
    text : str or bytes
        The XML document, as the topic ``robot_description`` has it.
    base_frame : str, optional
        Link the motion is measured from; default: the root link. It need not be an
        ancestor of the tip: joints between them may be passed upwards.
    tip_frame : str, optional
        Link that moves; default: the only leaf below the base, or the only one of several
        that is called ``tool0``, with or without a prefix.
    source : str
        Where the text comes from, for messages.
    warnings : sequence of str
        What is known already to be amiss with it.

    Returns
    -------
    SerialChain
        Screws at q = 0 in axes of the base link; fixed joints are folded in, and a joint
        that follows others follows the measured one at the end of that line. Its
        ``warnings`` name what was passed over.

    Raises
    ------
    ModelError
        The text is no URDF, the links no tree, a frame is unknown, nothing moves between
        base and tip, or a joint between them cannot be used.

    """
    document = read_document(source, text)
    try:
        return _chain(source, document, base_frame, tip_frame, warnings)
    except ModelError as error:
        missing = [note for note in document.foreign.values() if note.macro or note.holds_joints]
        if not missing or 'macro element' in error.problem:
            raise
        # Most likely this is why: what the elements stand for is not in the document.
        kind = 'macro' if missing[0].macro else 'unknown'
        raise ModelError(source, f'{error.problem}; line {missing[0].line}: got the {kind} '
                         f'element {missing[0].tag[:80]!r}; '
                         + (_EXPANDED if missing[0].macro else "allowed: 'link', 'joint'")
                         ) from None


def _chain(source: str, document: RobotDocument, base_frame: str | None,
           tip_frame: str | None, warnings: Sequence[str]) -> SerialChain:
    joints = _Joints(source, document)
    tree = LinkTree(source, _link_names(source, document), joints.edges)
    warnings = [*warnings, *_warnings(document)]
    if base_frame is None or tip_frame is None:
        _check_whole(source, document)
    base = tree.root if base_frame is None else base_frame
    tip = tip_frame
    if tip is None:
        leaves = tree.leaves(base)
        tip = _only_leaf(source, leaves, base, tree.below(base))
        if len(leaves) > 1:
            warnings.append(f'tip frame: {tip!r} is taken, of the leaf links {listed(leaves)}')
    path = tree.path(base, tip)
    if len(path) > MAX_JOINTS:
        raise ModelError(source, f'{len(path)} joints between base frame {base!r} and tip '
                         f'frame {tip!r}; allowed: at most {MAX_JOINTS}')
    T_base_link = pose()
    screws = []
    for edge, downwards in path:
        T_parent_joint = joints.origin(edge.joint)
        if downwards:
            T_base_link = T_base_link @ T_parent_joint
        joint = joints.screw(edge.joint, T_base_link, 1 if downwards else -1)
        if joint is not None:
            screws.append(joint)
        if not downwards:
            T_base_link = T_base_link @ inverse(T_parent_joint)
    if not screws:
        raise ModelError(source, f'nothing moves between base frame {base!r} and tip frame '
                         f'{tip!r}; allowed: frames with a moving joint between them')
    with reported(source):
        return SerialChain(screws, T_base_link, base, tip, document.name, warnings,
                           dict(_fixed_frames(joints, tip)), dict(_fixed_frames(joints, base)))


def _fixed_frames(joints: _Joints, frame: str) -> Iterator[tuple[str, Array]]:
    """Yield the links that are fixed to one, each with its pose in it."""
    beside: dict[str, list[tuple[Edge, bool]]] = {}
    for edge in joints.edges:
        if joints.is_fixed(edge.joint):
            beside.setdefault(edge.parent, []).append((edge, True))
            beside.setdefault(edge.child, []).append((edge, False))
    found, waiting = {frame: pose()}, [frame]
    while waiting:
        link = waiting.pop()
        for edge, downwards in beside.get(link, ()):
            other = edge.child if downwards else edge.parent
            if other in found:
                continue
            try:
                origin = joints.origin(edge.joint)
            except ModelError:      # a defect beside the arm does not stop it
                continue
            found[other] = found[link] @ (origin if downwards else inverse(origin))
            if np.isfinite(found[other]).all():
                waiting.append(other)
                yield other, found[other]


class _Joints:
    """The joints of a document by name, read on demand."""

    def __init__(self, source: str, document: RobotDocument) -> None:
        self._source = source
        self._version = document.version
        self._elements: dict[str, JointElement] = {}
        self.edges = []
        for i, element in enumerate(document.joints, start=1):
            name = Fields(source, f'joint {i} of the document', element.attributes).text('name')
            self._elements[name] = element
            self.edges.append(Edge(name, self._part(name, 'parent').text('link'),
                                   self._part(name, 'child').text('link')))

    def _part(self, name: str, tag: str, known: Sequence[str] | None = None) -> Fields:
        return Fields(self._source, f'joint {name!r}: {tag}',
                      self._elements[name].parts.get(tag, {}), known)

    def _read(self, name: str) -> JointElement:
        """Return a joint's element, after checking that it says all there is to say."""
        element = self._elements[name]
        fields = Fields(self._source, f'joint {name!r}', element.attributes)
        if element.stranger is not None:
            what, line, meant = element.stranger
            raise fields.error(f'line {line}: got {what}, which may change the joint; '
                               f'{meant or _EXPANDED}')
        for values in (element.attributes, *element.parts.values()):
            for key, value in values.items():
                if '${' in value or '$(' in value:
                    raise fields.error(f'{key}: got {value[:80]!r}, which no macro element was '
                                       f'left to expand; {_EXPANDED}')
        return element

    def kind(self, name: str, kinds: tuple[str, ...]) -> str:
        """Return the joint's type if it is one of those allowed here."""
        element = self._read(name)
        fields = Fields(self._source, f'joint {name!r}', element.attributes)
        kind = fields.raw('type')
        if kind in _FREE:
            child = self._part(name, 'child').text('link')
            raise fields.wrong(kind, f'{listed(kinds)}; choose a base frame below it, such as '
                               f'its child link {child!r}', 'type')
        return fields.choice('type', kinds)

    def is_fixed(self, name: str) -> bool:
        """Return whether a joint says that it is fixed, whatever else is wrong with it."""
        return self._elements[name].attributes.get('type') == 'fixed'

    def origin(self, name: str) -> Array:
        """Return the pose of the joint frame in the parent link at q = 0."""
        self._read(name)
        origin = self._part(name, 'origin', ('xyz', 'rpy', 'quat_xyzw'))
        xyz = origin.numbers('xyz', 3, (0, 0, 0))
        if 'quat_xyzw' not in origin:
            return pose(rotation_rpy(*origin.numbers('rpy', 3, (0, 0, 0))), xyz)
        if 'rpy' in origin:
            raise origin.wrong(origin.raw('quat_xyzw'), 'rpy or quat_xyzw, not both', 'quat_xyzw')
        if _version(self._version) < (1, 1):
            raise origin.wrong(origin.raw('quat_xyzw'), 'rpy; quat_xyzw needs <robot '
                               f'version="1.1">, this one has {self._version!r}', 'quat_xyzw')
        quaternion = origin.numbers('quat_xyzw', 4)
        if abs(sqrt(sum(x * x for x in quaternion)) - 1) > 1e-2:
            raise origin.wrong(origin.raw('quat_xyzw'), 'a quaternion of length 1', 'quat_xyzw')
        return pose(rotation_from_quaternion(np.array(quaternion)), xyz)

    def screw(self, name: str, T_base_joint: Array, sense: int    # noqa: N803
              ) -> Joint | None:
        """
        Return the joint as a screw in the base frame, or None if it is fixed.

        Passed from child to parent (sense -1), a joint moves its parent relative to its
        child: the same line, the opposite screw.
        """
        kind = self.kind(name, _KINDS)
        if kind == 'fixed':
            return None
        axis = self._axis(name)
        direction = sense * (T_base_joint[:3, :3] @ axis) + 0.0     # no negative zeros
        mimic = resolve_mimic(self._source, name, self._followed)
        if mimic is not None:
            mimic = replace(mimic, kind=self.kind(mimic.joint, _MOVING),
                            velocity_limit=self.velocity_limit(mimic.joint))
        with reported(self._source):
            return Joint(name, kind, direction, T_base_joint[:3, 3], mimic=mimic,
                         velocity_limit=self.velocity_limit(name))

    def _axis(self, name: str) -> list[float]:
        axis = self._part(name, 'axis', ('xyz', 'rpy'))
        if any(axis.numbers('rpy', 3, (0, 0, 0))):      # some exporters write zeros
            raise axis.wrong(axis.raw('rpy'), 'xyz only', 'rpy')
        return axis.numbers('xyz', 3, (1, 0, 0))

    def velocity_limit(self, name: str) -> float:
        """Return the largest speed the description states; many state 0 for none."""
        limit = number(self._elements[name].parts.get('limit', {}).get('velocity'))
        return limit if limit is not None and limit > 0 else inf

    def _followed(self, name: str) -> Mimic | None:
        """Return the joint's own ``mimic``, after checking that its source moves."""
        if 'mimic' not in self._read(name).parts:
            return None
        mimic = self._part(name, 'mimic', ('joint', 'multiplier', 'offset'))
        followed = mimic.text('joint')
        if followed not in self._elements:
            raise mimic.wrong(followed, f'a joint ({listed(self._elements, near=followed)})',
                              'joint')
        if self._elements[followed].attributes.get('type') == 'fixed':
            raise mimic.wrong(followed, 'a joint that moves; this one is fixed', 'joint')
        self.kind(followed, _MOVING)
        return Mimic(followed, mimic.number('multiplier', 1.0), mimic.number('offset', 0.0))


def _version(text: str) -> tuple[int, ...]:
    """Return the numbers of a version, lowest if it has none."""
    return tuple(map(int, text.split('.'))) if re.fullmatch(r'\d{1,9}(\.\d{1,9})*', text) \
        else (0,)


def _link_names(source: str, document: RobotDocument) -> list[str]:
    return [Fields(source, f'link {i} of the document', {'name': name}).text('name')
            for i, name in enumerate(document.links, start=1)]


def _warnings(document: RobotDocument) -> Iterator[str]:
    for note in document.foreign.values():
        kind = 'macro' if note.macro else 'unknown'
        yield (f'line {note.line}: the {kind} element {note.tag[:80]!r} is passed over; what it '
               'stands for is not in the model')


def _check_whole(source: str, document: RobotDocument) -> None:
    """Refuse to choose frames where links or joints of the robot are inside macros."""
    for note in document.foreign.values():
        if note.macro and note.holds_joints:
            raise ModelError(source, f'line {note.line}: got the macro element '
                             f'{note.tag[:80]!r} with links or joints in it; {_EXPANDED}')


def _only_leaf(source: str, leaves: Sequence[str], base: str, below: Sequence[str]) -> str:
    """Return the tip frame that nobody named."""
    # With a gripper at it the flange is no leaf.
    likely = [*(link for link in below if link != base and link.lower().endswith('tool0')),
              *(leaf for name in _TIPS for leaf in leaves if re.search(name, leaf.lower()))]
    certain = [leaf for leaf in leaves if leaf.lower().endswith('tool0')]
    if len(leaves) > 1 and len(certain) != 1:
        meant = f'; likely {listed(dict.fromkeys(likely))}' if likely else ''
        raise ModelError(source, f'tip frame is needed, because base frame {base!r} has '
                         f'several leaf links below it: {listed(leaves)}{meant}')
    return (certain if len(leaves) > 1 else leaves)[0]

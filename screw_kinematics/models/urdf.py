# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Chains from URDF.

Read directly, not with a general parser: a chain needs six tags, and the general ones
resolve entities, print to the terminal, or stop at tags that are none of their business.
Only the joints between base and tip, and those they follow, are read in full, so a
defect elsewhere in a description does not stop an arm.

References
----------
URDF specification, http://wiki.ros.org/urdf/XML/joint

"""
from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from .fields import Fields, listed, number, reported
from .following import followed_joint
from .guarded_xml import JointElement, read_document, RobotDocument
from .link_tree import Edge, LinkTree
from ..chains.joint import Joint, Mimic
from ..chains.serial_chain import SerialChain
from ..errors import ModelError
from ..screws.rotations import pose, rotation_rpy
from ..screws.se3 import Array, inverse

_MOVING = ('revolute', 'continuous', 'prismatic')
_KINDS = ('fixed', *_MOVING)
MAX_JOINTS = 1000    # between base and tip


@np.errstate(over='ignore', invalid='ignore')    # what overflows is refused as not finite
def load_urdf(text: str | bytes, base_frame: str | None = None, tip_frame: str | None = None,
              source: str = 'robot_description') -> SerialChain:
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
        Link that moves; default: the only leaf below the base, if there is but one.
    source : str
        Where the text comes from, for messages.

    Returns
    -------
    SerialChain
        Screws at q = 0 in axes of the base link; fixed joints are folded in, and a joint
        that follows others follows the measured one at the end of that line.

    Raises
    ------
    ModelError
        The text is no URDF, the links no tree, a frame is unknown, nothing moves between
        base and tip, or a joint between them cannot be used.

    """
    document = read_document(source, text)
    joints = _Joints(source, document)
    tree = LinkTree(source, _link_names(source, document), joints.edges)
    base = tree.root if base_frame is None else base_frame
    tip = _only_leaf(source, tree, base) if tip_frame is None else tip_frame

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
        return SerialChain(screws, T_base_link, base, tip, document.name)


class _Joints:
    """The joints of a document by name, read on demand."""

    def __init__(self, source: str, document: RobotDocument) -> None:
        self._source = source
        self._elements: dict[str, JointElement] = {}
        self.edges = []
        for i, element in enumerate(document.joints, start=1):
            name = Fields(source, f'joint {i} of the document', element.attributes).text('name')
            self._elements[name] = element
            self.edges.append(Edge(name, self._part(name, 'parent').text('link'),
                                   self._part(name, 'child').text('link')))

    def _part(self, name: str, tag: str) -> Fields:
        return Fields(self._source, f'joint {name!r}: {tag}',
                      self._elements[name].parts.get(tag, {}))

    def kind(self, name: str, kinds: tuple[str, ...]) -> str:
        """Return the joint's type if it is one of those allowed here."""
        return Fields(self._source, f'joint {name!r}',
                      self._elements[name].attributes).choice('type', kinds)

    def origin(self, name: str) -> Array:
        """Return the pose of the joint frame in the parent link at q = 0."""
        origin = self._part(name, 'origin')
        return pose(rotation_rpy(*origin.numbers('rpy', 3, (0, 0, 0))),
                    origin.numbers('xyz', 3, (0, 0, 0)))

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
        axis = self._part(name, 'axis').numbers('xyz', 3, (1, 0, 0))
        direction = sense * (T_base_joint[:3, :3] @ axis) + 0.0     # no negative zeros
        mimic = followed_joint(self._source, name, self._followed)
        if mimic is not None:
            mimic = replace(mimic, kind=self.kind(mimic.joint, _MOVING),
                            velocity_limit=self.velocity_limit(mimic.joint))
        with reported(self._source):
            return Joint(name, kind, direction, T_base_joint[:3, 3], mimic=mimic,
                         velocity_limit=self.velocity_limit(name))

    def velocity_limit(self, name: str) -> float:
        """Return the largest speed the description states; many state 0 for none."""
        limit = number(self._elements[name].parts.get('limit', {}).get('velocity'))
        return limit if limit is not None and limit > 0 else inf

    def _followed(self, name: str) -> Mimic | None:
        """Return the joint's own ``mimic``, after checking that its source moves."""
        if 'mimic' not in self._elements[name].parts:
            return None
        mimic = self._part(name, 'mimic')
        followed = mimic.text('joint')
        if followed not in self._elements:
            raise mimic.wrong(followed, f'a joint ({listed(self._elements)})', 'joint')
        if self._elements[followed].attributes.get('type') == 'fixed':
            raise mimic.wrong(followed, 'a joint that moves; this one is fixed', 'joint')
        self.kind(followed, _MOVING)
        return Mimic(followed, mimic.number('multiplier', 1.0), mimic.number('offset', 0.0))


def _link_names(source: str, document: RobotDocument) -> list[str]:
    return [Fields(source, f'link {i} of the document', {'name': name}).text('name')
            for i, name in enumerate(document.links, start=1)]


def _only_leaf(source: str, tree: LinkTree, base: str) -> str:
    leaves = tree.leaves(base)
    if len(leaves) > 1:
        raise ModelError(source, f'tip frame is needed, because base frame {base!r} has '
                         f'several leaf links below it: {listed(leaves)}')
    return leaves[0]

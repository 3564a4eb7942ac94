# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Whatever a description says, it loads or is refused by an error of the package."""
from pathlib import Path
import tracemalloc
from xml.sax.saxutils import quoteattr

from hypothesis import example, given, settings, strategies as st
import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ScrewKinematicsError
from screw_kinematics.models.guarded_yaml import read_yaml
from screw_kinematics.models.model_file import robot_from_data
import yaml

MOST_BYTES = 64e6
ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'

fuzz = settings(max_examples=200, deadline=None, derandomize=True)

# All that can be encoded, without trying each, as by default.
characters = st.characters(exclude_categories=['Cs'])
hostile = st.one_of(
    st.floats().map(str), st.text(characters, max_size=5), st.sampled_from([
        '1e308', '-1e308', '5e-324', '1e999', '0x10', '1_0', '', 'pi', '${pi}', '٣', 'l0', 'j0']))
numbers = st.floats(-9, 9).map(str)
kinds = st.sampled_from(['revolute', 'continuous', 'prismatic'])
vectors = st.lists(numbers, min_size=3, max_size=3)
triples = vectors.map(' '.join)
turned = st.one_of(
    triples.map(lambda angles: f'rpy="{angles}"'),
    st.sampled_from(['quat_xyzw="0 0 0 1"', 'quat_xyzw="0.6 0 0.8 0"', '', 'quat_xyzw="0"']))
left = st.sampled_from(['', '', '', '<xacro:if value="1"/>', '<dynamics/>', '<odd/>'])


def check(load):
    """Load; if that succeeds the chain must be usable, else the error ours."""
    try:
        chain = load()
    except ScrewKinematicsError as error:
        assert len(str(error)) < 5000
        return
    pose = chain.home.pose if hasattr(chain, 'home') else chain.pose(np.zeros(chain.dof))
    assert np.all(np.isfinite(pose)) or any(
        joint.mimic is not None for joint in chain.joints)
    assert chain.dof >= 1


@st.composite
def urdf_texts(draw):
    """Return a tree of links with, now and then, a wrong value in some attribute."""
    count = draw(st.integers(1, 6))
    lines = ['<link name="l0"/>']
    for i in range(count):
        mimic = f'<mimic joint="j{draw(st.integers(0, count))}" multiplier="{draw(numbers)}"/>'
        lines.append(
            f'<link name="l{i + 1}"/><joint name="j{i}" type="{draw(kinds)}">'
            f'<parent link="l{draw(st.integers(0, i))}"/><child link="l{i + 1}"/>'
            f'<origin xyz="{draw(triples)}" {draw(turned)}/><axis xyz="{draw(triples)}"/>'
            f'{draw(left)}'
            f'{mimic if draw(st.integers(0, 4)) == 0 else ""}</joint>')
    version = draw(st.sampled_from(['1.0', '1.1', '1.1', '2', 'x']))
    lines.append(draw(left))
    pieces = (f'<robot name="r" version="{version}">' + ''.join(lines) + '</robot>').split('"')
    for _ in range(draw(st.integers(0, 2))):
        where = 2 * draw(st.integers(0, len(pieces) // 2 - 1)) + 1
        pieces[where] = quoteattr(draw(hostile))[1:-1].replace('"', '')
    return '"'.join(pieces)


@fuzz
@given(urdf_texts(), st.sampled_from([None, 'l0', 'l1', 'x']),
       st.sampled_from(['l1', 'l1', 'l2', 'l3', None, 'x']))
def test_urdf_documents(text, base, tip):
    check(lambda: models.load_urdf(text, base, tip))


@st.composite
def damaged(draw, originals):
    """Return a valid text with a few slices moved, doubled, dropped or overwritten."""
    data = draw(st.sampled_from(originals))
    for _ in range(draw(st.integers(1, 4))):
        start, stop, to = sorted(draw(st.tuples(*[st.integers(0, len(data))] * 3)))
        put = draw(st.binary(max_size=8) | st.just(data[start:stop]) | st.just(b''))
        data = data[:start] + put + data[draw(st.sampled_from([start, stop, to])):]
    return data


URDF = b"""<?xml version="1.0"?>
<robot name="r"><link name="a"/><link name="b"/><link name="c"><visual/></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="1 2 3" rpy="0 1 2"/><axis xyz="0 0 1"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/>
<mimic joint="j" multiplier="2" offset=".1"/></joint></robot>"""


@fuzz
@given(damaged([URDF, URDF.replace(b'?>', b' encoding="latin-1"?>', 1),
                URDF.decode().encode('utf-16'), URDF.replace(b'?>', b' encoding="gbk"?>', 1)])
       | st.binary(max_size=50) | st.text(characters, max_size=50))
def test_urdf_bytes(data):
    check(lambda: models.load_urdf(data))


anything = st.recursive(hostile, lambda inner: st.one_of(
    st.lists(inner, max_size=4), st.dictionaries(hostile, inner, max_size=4)), max_leaves=6)
poses = st.fixed_dictionaries({}, optional={'xyz': vectors, 'rpy': vectors})
mimics = st.fixed_dictionaries({'joint': st.sampled_from(['j0', 'j1', 'x'])},
                               optional={'multiplier': numbers, 'offset': numbers})
screws = st.fixed_dictionaries({'kind': kinds, 'axis': vectors, 'point': vectors},
                               optional={'mimic': mimics})
spindles = st.fixed_dictionaries({'kind': st.just('helical'), 'axis': vectors, 'pitch': numbers})
rows = st.fixed_dictionaries({'kind': kinds, 'a': numbers, 'alpha': numbers, 'd': numbers},
                             optional={'theta': numbers, 'mimic': mimics})
units = st.fixed_dictionaries({}, optional={'length': st.sampled_from(['mm', 'in']),
                                            'angle': st.sampled_from(['deg', 'rad'])})


@st.composite
def model_data(draw):
    """Return a model file's data with, now and then, a wrong value or key somewhere."""
    conventions = st.sampled_from(['standard', 'modified'])
    data = draw(st.one_of(
        st.fixed_dictionaries({'joints': st.lists(screws | spindles, min_size=1, max_size=4),
                               'home': poses, 'units': units}),
        st.fixed_dictionaries({
            'dh': st.fixed_dictionaries({
                'convention': conventions, 'rows': st.lists(rows, min_size=1, max_size=4)}),
            'base': poses, 'tool': poses, 'units': units})))
    for i, joint in enumerate(data.get('joints') or data['dh']['rows']):
        joint['name'] = f'j{i}'
    for _ in range(draw(st.integers(0, 2))):
        place = data
        while True:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            if not keys:
                break
            key = draw(st.sampled_from(keys))
            if not isinstance(place[key], (dict, list)) or draw(st.booleans()):
                place[key] = draw(anything)
                break
            place = place[key]
    return data


@fuzz
@given(model_data())
def test_model_files(data):
    text = yaml.safe_dump(data, allow_unicode=True)
    check(lambda: robot_from_data(read_yaml('arm.yaml', text), 'arm.yaml', 'arm'))


FILES = [path.read_bytes() for path in sorted(ROBOTS.glob('*.yaml'))]


@fuzz
@given(damaged([file for file in FILES if b'limbs:' not in file])
       | st.binary(max_size=50) | st.text(characters, max_size=50))
@example(b'!!timestamp x')
@example(b'? [a]\n: 1')
@example(b'a: 1:1:1:1')
@example('\udcff')
def test_model_bytes(data):
    check(lambda: robot_from_data(read_yaml('arm.yaml', data), 'arm.yaml', 'arm'))


@settings(fuzz, max_examples=30)
@given(damaged([file for file in FILES if b'limbs:' in file]))
def test_bytes_of_parallel_robots(data):
    check(lambda: robot_from_data(read_yaml('arm.yaml', data), 'arm.yaml', 'arm'))


@pytest.mark.parametrize('body', [
    '<link name="{0}"/><joint name="{0}" type="fixed"><parent link="0"/>'
    '<child link="{0}"/></joint>',
    '<joint name="a"/>', '<x{0}/>', '<x {1}/>'], ids=['links', 'joints', 'tags', 'attributes'])
def test_memory_is_bounded(body):
    """The largest texts that are read at all take 64 MB at the most to refuse."""
    attributes = ' '.join(f'a{i}=""' for i in range(3000)) if '{1}' in body else ''
    parts, size = [], 0
    while size < 3_900_000:
        parts.append(body.format(len(parts), attributes))
        size += len(parts[-1])
    text = '<robot>' + ''.join(parts) + '</robot>'
    tracemalloc.start()
    try:
        check(lambda: models.load_urdf(text))
        assert tracemalloc.get_traced_memory()[1] < MOST_BYTES
    finally:
        tracemalloc.stop()

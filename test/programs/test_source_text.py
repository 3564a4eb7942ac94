# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Source text of programs: it compiles without warnings and computes the same."""
import ctypes
import subprocess

import numpy as np
import pytest

from screw_kinematics import Joint, SerialChain
from screw_kinematics.errors import InvalidValueError, UnknownNameError
from support.c_compiler import COMPILER, needs_compiler
from support.program_cases import assert_close, CHAINS, motion, OUTPUTS
from support.robots import robot


def built(program, folder, name='tip_motion'):
    """Return the compiled C function as one of arrays."""
    (folder / f'{name}.h').write_text(program.source('c_header', name))
    source, library = folder / f'{name}.c', folder / f'{name}.so'
    source.write_text(program.source('c', name))
    subprocess.run([COMPILER, '-std=c99', '-Wall', '-Wextra', '-Wpedantic', '-Werror', '-O1',
                    '-shared', '-fPIC', str(source), '-o', str(library), '-lm'], check=True)
    function = getattr(ctypes.CDLL(str(library)), name)
    function.restype = None

    def call(*parts):
        sizes = [part.stop - part.start for part in program.slices.values()]
        outputs = [np.full(size, np.nan) for size in sizes]
        pointers = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
                    for array in [*parts[:program.order + 1], *outputs]]
        function(*pointers)
        return dict(zip(program.outputs, outputs))

    return call


@needs_compiler
@pytest.mark.parametrize('name, outputs, axes, pole', [
    ('panda', OUTPUTS, 'base', 'tip'), ('mimic', OUTPUTS, 'tip', 'base'),
    ('rpr', ('pose', 'accel'), 'base', 'tip'), ('slide', OUTPUTS, 'base', 'base'),
    ('fixed', ('pose',), 'base', 'tip')])
def test_c_source_computes_the_same(name, outputs, axes, pole, tmp_path):
    chain = CHAINS[name]
    program = chain.compile(outputs, axes, pole)
    function = built(program, tmp_path)
    samples = motion(chain, 3)
    for k in range(3):
        sample = [np.ascontiguousarray(part[k]) for part in samples]
        expected = program(*sample)
        for output, values in function(*sample).items():
            assert_close(values, expected[output])


@needs_compiler
def test_names_of_joints_and_frames_stay_in_the_comment(tmp_path):
    chain = SerialChain([Joint('a */ int x; /*', 'revolute', (0, 0, 1))],
                        base_frame='*/ #error "no"\n#error', tip_frame='\\')
    function = built(chain.compile('twist'), tmp_path, 'named')
    np.testing.assert_array_equal(function(np.zeros(1), np.ones(1))['twist'],
                                  [0, 0, 1, 0, 0, 0])


@pytest.mark.parametrize('frame', ['tool', '"""', '\\', "'", 'a\nb', '{q1}', '\\N'])
def test_python_source_stands_alone(frame):
    chain = CHAINS['rpr']
    chain = SerialChain(chain.joints, chain.T_base_tool, tip_frame=frame)
    program = chain.compile(('twist', 'pose'))
    scope = {}
    exec(program.source('python', 'forward'), scope)
    sample = [part[0] for part in motion(chain, 1, order=1)]
    found, expected = scope['forward'](*sample), program(*sample)
    for output in program.outputs:
        assert_close(np.array(found[output]), expected[output])


def test_the_comment_names_frames_joints_and_units():
    chain = SerialChain([Joint('lift', 'prismatic', (0, 0, 1))], base_frame='floor',
                        tip_frame='fork')
    text = chain.compile(('pose', 'accel'), axes='tip', pole='base').source('c_header')
    for part in ('motion of fork relative to floor', 'Joints: lift', 'rad/s^2, m/s^2',
                 'axes of fork', 'reference point at the origin of floor',
                 'pose: position p, then rotation'):
        assert part in text


@pytest.mark.parametrize('language, name, error, match', [
    ('rust', 'f', UnknownNameError, "language 'rust'; known: 'python', 'c', 'c_header'"),
    ('c', '2f', InvalidValueError, "'2f' is no name of a C function"),
    ('c_header', 'double', InvalidValueError, "'double' is no name of a C function"),
    ('python', 'lambda', InvalidValueError, "'lambda' is no name of a Python function")])
def test_what_cannot_be_written_is_refused(language, name, error, match):
    with pytest.raises(error, match=match):
        CHAINS['slide'].compile('twist').source(language, name)


def test_a_search_has_no_source_text():
    program = robot('planar_3rrr').compile('twist')
    with pytest.raises(InvalidValueError, match='found by iteration'):
        program.source('c')

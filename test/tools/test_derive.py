# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.tools import console, derive

pytest.importorskip('sympy')
ROBOTS = Path(__file__).parents[2] / 'config' / 'robots'
RPR = str(ROBOTS / 'rpr.yaml')


def test_text_of_the_planar_arm(capsys):
    assert derive.main([RPR]) == console.OK
    lines = capsys.readouterr().out.splitlines()
    assert 'pose, x of origin: q2*cos(q1) + cos(q1 + q3)/4' in lines
    assert 'twist, angular z: qd1 + qd3' in lines
    assert len(lines) == 12 + 6 + 6


@pytest.mark.parametrize('axes', ['base', 'tip'])
@pytest.mark.parametrize('pole', ['base', 'tip'])
@pytest.mark.parametrize('flag', [[], ['--unsimplified']])
def test_python_is_the_chain(axes, pole, flag, capsys):
    outputs = 'pose,twist,accel,reduced_jerk'
    assert derive.main([RPR, '--format', 'python', '--outputs', outputs, '--axes', axes,
                        '--pole', pole, *flag]) == console.OK
    namespace = {}
    exec(capsys.readouterr().out, namespace)
    motion = np.random.default_rng(1).normal(size=(4, 3))
    found = namespace['tip_motion'](*motion.ravel())
    state = models.load(RPR).state(*motion).about(pole).expressed_in(axes)
    for name, expected in (('pose', state.pose[:3].ravel()), ('twist', state.velocity),
                           ('accel', state.classical(2)), ('reduced_jerk', state.jerk)):
        np.testing.assert_allclose(found[name], expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize('format, text', [('latex', r'\begin{bmatrix}'),
                                          ('c', 'double twist[6])')])
def test_other_formats(format, text, capsys):    # noqa: A002
    assert derive.main([RPR, '--outputs', 'twist', '--format', format]) == console.OK
    assert text in capsys.readouterr().out


@pytest.mark.parametrize('outputs, message', [
    ('twist,force', "unknown output 'force'; known: 'pose', 'twist'"),
    (',', "parameter 'outputs' is ','; allowed: some of pose")])
def test_wrong_outputs_are_one_line(outputs, message, capsys):
    assert derive.main([RPR, '--outputs', outputs]) == console.FAILED
    assert message in capsys.readouterr().err


def test_closed_loops_are_refused(capsys):
    assert derive.main([str(ROBOTS / 'delta.yaml')]) == console.FAILED
    assert 'closed loops have no formulas here' in capsys.readouterr().err

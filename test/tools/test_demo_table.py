# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The demo's table in windows of any usual width."""
import io

import numpy as np
import pytest

Console = pytest.importorskip('rich.console').Console

from screw_kinematics.tools.demo.view import LiveTable, Row, View     # noqa: E402

ROWS = (Row('angular acceleration', 'alpha', 'rad/s2', np.array([-244.0046, -170.0112, -15.73]),
            np.array([-244.0, -170.0, -15.7])),
        Row('screw axis direction', 's', '', np.array([-0.5, -1.0, 0.25]), np.zeros(3)),
        Row('pitch', 'h', 'm/rad', np.array([-0.0725]), np.array([0.0])))


@pytest.mark.parametrize('width', [60, 80, 100])
def test_the_table_fits_and_nothing_is_cut_off(width):
    view = View('puma560, motion of the paper', 'motion of tool relative to base, in base', 12.3,
                ROWS, {'joint_states': 1000.0, 'twist': 1000.0}, 0.002, 0.0)
    console = Console(width=width, file=io.StringIO())
    console.print(LiveTable(view))
    lines = console.file.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    for row in ROWS:
        name = row.quantity if width >= 80 else row.symbol
        shown, = (line for line in lines if line.strip().startswith(f'{name} '))
        numbers = [float(word) for word in shown.split() if word[-1].isdigit() and '/' not in word]
        assert np.allclose(numbers[:-1], row.measured, atol=5e-4)
        assert numbers[-1] == pytest.approx(row.error, rel=0.05)

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The work for a chain grows with its length, not with the square of it."""
import time

import numpy as np
from screw_kinematics import Joint, SerialChain
from screw_kinematics.tools.check.model import report_model


def chain_of(n):
    """Return a chain of n turning joints that lie anyhow."""
    rng = np.random.default_rng(n)
    return SerialChain([Joint(f'q{k}', 'revolute', rng.normal(size=3), rng.normal(size=3))
                        for k in range(n)])


def timed(work, *arguments):
    """Return a result, and the processor time it took [s]."""
    begin = time.process_time()
    result = work(*arguments)
    return result, time.process_time() - begin


def test_a_program_of_400_joints():
    short, first = timed(chain_of(100).compile, ('twist', 'accel'))
    long, second = timed(chain_of(400).compile, ('twist', 'accel'))
    assert long.operations < 4.2 * short.operations
    assert second < 10 * first + 1.0 and second < 5.0


def test_a_check_of_400_joints():
    findings, seconds = timed(lambda: [f.what for f in report_model(chain_of(400))])
    assert 'tool moves in 6 of 6 directions; 394 joint(s) to spare' in findings
    assert seconds < 15.0

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Programs that are joined give what each gives by itself, to the last bit, in less work."""
import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.programs.joining import joined
from screw_kinematics.programs.machine import machine
from support import robots


@pytest.mark.parametrize('outputs', [('twist',), ('pose', 'twist', 'accel'), ('jerk', 'jacobian')])
def test_joined_programs_give_the_same_bits(outputs):
    """Chains of shared joints in different orders, beside each other."""
    rng = np.random.default_rng(1)
    chains = [robots.random_chain(seed, kinds) for seed, kinds in enumerate(
        [('revolute',) * 4, ('prismatic', 'revolute', 'helical'), ('revolute',) * 6])]
    programs = [chain.compile(outputs) for chain in chains]
    order, n = programs[0].order, 8
    columns = [rng.permutation(n)[:chain.dof].tolist() for chain in chains]
    parts = [(program.line, [d * n + c for d in range(order + 1) for c in own])
             for program, own in zip(programs, columns)]
    whole = machine(joined(parts, n * (order + 1)))
    for values in rng.normal(size=(20, n * (order + 1))).tolist():
        expected = [x for program, (_, inputs) in zip(programs, parts)
                    for x in program.evaluate([values[i] for i in inputs])]
        assert list(whole.evaluate(values)) == expected


def test_what_two_tips_have_in_common_is_computed_once():
    arm = models.load('package://screw_kinematics/config/robots/panda.yaml')
    programs = [chain.compile(('twist', 'accel')) for chain in (
        arm, arm.with_tool(np.diag([-1.0, -1.0, 1.0, 1.0])))]
    inputs = list(range(programs[0].inputs))
    line = joined([(program.line, inputs) for program in programs], len(inputs))
    assert line.count()['sin'] == line.count()['cos'] == 6
    assert len(line.operations) < 1.8 * len(programs[0].line.operations)
    same = joined([(programs[0].line, inputs)] * 3, len(inputs))
    assert len(same.operations) == len(programs[0].line.operations)

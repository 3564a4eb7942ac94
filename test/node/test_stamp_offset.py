# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock of the joint states is set right before all else: live, while it runs, and offline."""
from geometry_msgs.msg import TwistStamped
import numpy as np
import pytest
from screw_kinematics import models
from support.rig import joint_state, PUMA, RELIABLE_INPUT, running, six, smooth_motion, stamp_ns

START, STEP = 10**11, 5_000_000
ROBOT = models.load(PUMA)


def test_live(context, tmp_path):
    parameters = {'robots': ['puma'], 'diagnostics_rate': 20.0,
                  'qos_overrides': {'/joint_states': {'subscription': RELIABLE_INPUT}},
                  'puma': {'description': PUMA, 'stamp_offset': 0.2517}}
    with running(context, tmp_path, parameters) as rig:
        got = rig.listen('puma/twist', TwistStamped)
        states = rig.publisher('joint_states')
        k = 0

        def play(until):
            nonlocal k
            while not until():
                k += 1
                q, qd = smooth_motion(6, k * STEP * 1e-9)
                states.publish(joint_state(ROBOT.joint_names, START + k * STEP, q, qd))
                rig.spin(0.003)

        play(lambda: len(got) > 60)
        offsets = [251_700_000]
        for offset in (-0.0123, 0.0):       # back in time, too
            assert rig.set_parameters(puma__stamp_offset=offset).successful
            offsets.append(round(offset * 1e9))
            n = len(got)
            play(lambda: len(got) > n + 60)
        # Each message is that of one of the clocks, one after the other, and its content is the
        # same motion.
        found = [next((o for o in offsets if (stamp_ns(m) - o - START) % STEP == 0
                       and 0 < stamp_ns(m) - o - START <= k * STEP), None) for m in got]
        assert found[0] == offsets[0] and found[-1] == 0 and offsets[1] in found
        exact = [ROBOT.state(*smooth_motion(6, (stamp_ns(m) - START) * 1e-9)).classical(1)
                 for m in got[-20:]]
        np.testing.assert_allclose([six(m.twist) for m in got[-20:]], exact, atol=1e-3)
        result = rig.set_parameters(puma__stamp_offset=11.0)
        assert not result.successful and 'stamp_offset' in result.reason


def test_offline(tmp_path, capsys):
    rec = pytest.importorskip('support.recordings')
    from screw_kinematics.tools.bag import main as bag
    path = rec.write_bag(tmp_path / 'run', rec.samples(400))
    stamps = []
    for offset in (0.0, -0.0123):
        file = tmp_path / 'parameters.yaml'
        file.write_text('kinematic_state_publisher:\n  ros__parameters:\n    robots: [puma]\n'
                        f'    puma: {{description: "{PUMA}", stamp_offset: {offset}}}\n')
        assert bag.main([str(path), '--params-file', str(file), '--output',
                         str(tmp_path / f'out{offset}')]) == 0, capsys.readouterr()
        stamps.append([rec.stamp_of(m) for _, m in
                       rec.read_bag(tmp_path / f'out{offset}')['/puma/twist']])
    assert len(stamps[0]) == 400
    assert set(np.subtract(stamps[1], stamps[0]).tolist()) == {-12_300_000}

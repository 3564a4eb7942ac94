# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Wrenches out of recordings: what cannot be compensated is one line."""
import re

import pytest

pytest.importorskip('mujoco')

from screw_kinematics.errors import MalformedMessageError    # noqa: E402
from screw_kinematics.messages.wrench import read_wrench, WrenchSample    # noqa: E402
from screw_kinematics.tools.bag import main as bag    # noqa: E402
from support import loaded_arm as arm, loaded_recording, recordings as rec    # noqa: E402

PARAMETERS = """
kinematic_state_publisher:
  ros__parameters:
    robots: [arm]
    arm:
      description: {urdf}
      tip_frame: tool0
      outputs: [compensated_wrench]
      wrench_topic: {topic}
      wrench_bias: {bias}
      payload: {{mass: {mass}, center: {center}, inertia: {inertia}}}
"""


def run(tmp_path, topic='ft', mass=arm.BODY.mass, messages=None, **options):
    """Write a bag, and make the compensated wrenches of it; return the exit code."""
    urdf, file = tmp_path / 'arm.urdf', tmp_path / 'parameters.yaml'
    urdf.write_text(arm.urdf())
    file.write_text(PARAMETERS.format(
        urdf=urdf, topic=topic, mass=mass, bias=arm.BIAS.tolist(), center=list(arm.BODY.center),
        inertia=list(arm.BODY.inertia)))
    path = rec.write_bag(
        tmp_path / 'run', messages or loaded_recording.messages(seconds=2.0, **options))
    return bag.main([str(path), '--params-file', str(file), '--output', str(tmp_path / 'out')])


def test_messages_are_those_of_the_node(tmp_path, capsys):
    assert run(tmp_path) == 0, capsys.readouterr()
    found = rec.read_bag(tmp_path / 'out')
    assert set(found) == {'/arm/compensated_wrench'}
    assert len(found['/arm/compensated_wrench']) > 950


def test_wrenches_of_another_time_are_told(tmp_path, capsys):
    assert run(tmp_path, shift=1.0) in (0, 1)
    captured = capsys.readouterr()
    said = ' '.join((captured.out + captured.err).split())
    assert re.search('ft: no wrench was measured around 50. of the instants of the joints', said)


def test_some_that_are_of_no_use_are_told_with_what_is_allowed(tmp_path, capsys):
    messages = [*loaded_recording.messages(seconds=2.0)]
    for k in [k for k, m in enumerate(messages) if m[0] == '/ft'][300:305]:
        topic, kind, received, _ = messages[k]
        messages[k] = topic, kind, received, loaded_recording.wrench(received, [0.0] * 6, 'hand')
    assert run(tmp_path, messages=messages) == 0
    assert "5 wrenches refused: frame_not_fixed_to_tip (frame_id is 'hand'; allowed: ft_frame" in (
        ' '.join(capsys.readouterr().out.split()))


@pytest.mark.parametrize('options, message', [
    ({'topic': 'nothing'}, 'no wrenches on /nothing; topics of type geometry_msgs/msg/'
     'WrenchStamped: /ft'),
    ({'frame': 'hand'}, '/ft: every wrench is refused: frame_not_fixed_to_tip '
     "(frame_id is 'hand'; allowed: "),
    ({'mass': -1.0}, "parameter 'arm.payload.mass' is -1.0; allowed: a number from 0")])
def test_what_is_wrong_is_one_line(options, message, tmp_path, capsys):
    assert run(tmp_path, **options) != 0
    captured = capsys.readouterr()
    assert message in ' '.join((captured.out + captured.err).split()), captured
    assert 'Traceback' not in captured.err


def test_bytes_are_read_as_they_were_written():
    values = (1.0, -2.0, 3.0, 0.1, 0.2, -0.3)
    for frame in ('', 'a', 'tool0', 'left/ft_frame', 'größe'):
        data = loaded_recording.wrench(1_700_000_000_123_456_789, values, frame)
        assert read_wrench(data) == WrenchSample(1_700_000_000_123_456_789, frame, values)
    for broken in (data[:-1], data[:11], b'', data + bytes(9), b'\0\2' + data[2:],
                   data[:12] + b'\xff\xff\xff\xff' + data[16:]):
        with pytest.raises(MalformedMessageError, match='a WrenchStamped message is malformed'):
            read_wrench(broken)

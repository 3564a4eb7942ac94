# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameter files mean to the tools what ROS's own parser makes of them for the node."""
import pytest

from screw_kinematics.errors import ParameterError, ToolError
from screw_kinematics.pipeline.parameter_file import read_robots

PUMA = 'package://screw_kinematics/config/robots/puma560.yaml'
ARM = f"""\
/**:
  ros__parameters:
    robots: ['on']
    'on':
      description: {PUMA}
"""


def read(tmp_path, *texts):
    path = tmp_path / 'kinematic_states.yaml'
    path.write_text(''.join(texts))
    robot, = read_robots(path)
    return robot


def test_values_are_those_that_ros_reads(tmp_path):
    robot = read(tmp_path, ARM, """\
      stale_timeout: 2e-1
      frame_prefix: 2026-01-01
      tool_offset: [0.0, 1e-1, .5, +1., -1.5E-1, 0.0]
      estimator: {delay: 2e-2}
""")
    assert robot.name == 'on'
    assert robot.stale_timeout == 0.2 and robot.motion.delay == 0.02
    assert robot.frame_prefix == '2026-01-01'
    assert list(robot.tool_offset) == [0, 0.1, 0.5, 1, -0.15, 0]


def test_files_that_were_joined_count_both(tmp_path):
    """As when what the tool identify prints is put behind a file of parameters."""
    robot = read(tmp_path, ARM, ARM.replace(f'description: {PUMA}', 'estimator: {delay: 0.05}')
                 .replace("    robots: ['on']\n", ''))
    assert robot.description == PUMA and robot.motion.delay == 0.05


@pytest.mark.parametrize('wrong, sentence', [
    ('base_frame: ', "parameter 'on.base_frame' is not given; allowed: a value"),
    ('estimator:', "parameter 'on.estimator' is not given; allowed: a value"),
    ('tool_offset: [0, 0, 0.1, 0, 0, 0]', r"'on.tool_offset' is \[0, 0, 0.1, 0, 0, 0\]; allowed: "
     'a list of one type'),
    ('estimator: {delay: 0.02}\n      estimator.delay: 0.05',
     r"'on.estimator.delay' is \[0.02, 0.05\]; allowed: once"),
    ('frame_prefix: on', "'on.frame_prefix' is True; allowed: a string"),
])
def test_what_the_node_would_not_read_or_not_notice(wrong, sentence, tmp_path):
    with pytest.raises(ParameterError, match=sentence):
        read(tmp_path, ARM, f'      {wrong}\n')


def test_a_file_that_is_not_there_is_named_once(tmp_path):
    with pytest.raises(ToolError) as error:
        read_robots(tmp_path / 'nowhere.yaml')
    assert str(error.value) == f'{tmp_path}/nowhere.yaml: No such file or directory'

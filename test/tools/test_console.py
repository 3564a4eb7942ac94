# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The one command: names of tools, usage errors, completion by shells, arguments of ROS."""
import os
from pathlib import Path
import subprocess
import sys

import pytest
import screw_kinematics
from screw_kinematics import core
from screw_kinematics.node.main import main as node, without_ros_arguments
from screw_kinematics.tools.console import command_of
from screw_kinematics.tools.main import main, tool_names

ROOT = Path(__file__).parents[2]


def run(*words, **environment):
    return subprocess.run([sys.executable, '-m', 'screw_kinematics', *words], cwd=ROOT, text=True,
                          capture_output=True, env={**os.environ, **environment})


def test_the_command_says_its_version():
    told = f'screw-kinematics {screw_kinematics.__version__}; {core.build()}\n'
    assert run('--version').stdout == told


@pytest.mark.parametrize('tool', tool_names())
def test_each_tool_says_its_version(tool, capsys):
    with pytest.raises(SystemExit) as ended:
        main([tool, '--version'])
    assert ended.value.code == 0
    told = f'{command_of(tool, Path("x"))} {screw_kinematics.__version__}; {core.build()}\n'
    assert capsys.readouterr().out == told


def test_the_node_says_its_version(capsys):
    with pytest.raises(SystemExit) as ended:
        node(['kinematic_state_publisher', '--version'])
    assert ended.value.code == 0
    assert capsys.readouterr().out.split()[1] == f'{screw_kinematics.__version__};'


@pytest.mark.parametrize('words, problem, example', [
    ([], 'which tool? bag, check, demo', 'screw-kinematics demo --once'),
    (['nope'], "invalid choice: 'nope'", 'screw-kinematics demo --once'),
    (['plot'], 'required: KIND', 'screw-kinematics plot figure11'),
    (['plot', 'screws'], 'required: MODEL', 'screw-kinematics plot screws config/'),
    (['check', 'model'], 'required: MODEL', 'screw-kinematics check model '),
    (['derive'], 'required: MODEL', 'screw-kinematics derive config/'),
    (['demo', '--motion', 'x'], "invalid choice: 'x'", 'screw-kinematics demo'),
])
def test_usage_errors_are_one_line_with_an_example(capsys, words, problem, example):
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1
    assert problem in error and f'for example: {example}' in error


def test_help_has_the_examples_of_what_it_is_for(capsys):
    with pytest.raises(SystemExit):
        main(['check', 'delay', '--help'])
    examples = capsys.readouterr().out.partition('\nexamples:\n')[2].splitlines()
    assert len(examples) > 2 and examples[-1].startswith('     ')
    assert all(line.startswith(('  screw-kinematics check delay ', '     ')) for line in examples)


@pytest.mark.parametrize('typed, wanted', [
    ('screw-kinematics ', {'bag', 'check', 'demo', 'derive', 'plot', '--version'}),
    ('screw-kinematics de', {'demo', 'derive'}),
    ('screw-kinematics plot ', {'figure11', 'motion', 'recorded', 'screws'}),
    ('screw-kinematics check bag --to', {'--topic'}),
    ('screw-kinematics demo --motion ', {'paper', 'minjerk', 'multisine'}),
])
def test_a_shell_completes_names_and_options(tmp_path, typed, wanted):
    answer = tmp_path / 'answer'
    run(COMP_LINE=typed, COMP_POINT=str(len(typed)), _ARGCOMPLETE='1', _ARGCOMPLETE_IFS='\n',
        _ARGCOMPLETE_SHELL='bash', _ARGCOMPLETE_STDOUT_FILENAME=str(answer))
    assert wanted <= {word.strip() for word in answer.read_text().split('\n')}


def test_the_text_for_a_shell_is_one_it_can_read():
    text = run('--completion', 'bash').stdout
    shell = subprocess.run(['bash', '-c', f'{text}\ncomplete -p screw-kinematics'],
                           capture_output=True, text=True)
    assert 'screw-kinematics' in shell.stdout, shell.stderr


@pytest.mark.parametrize('program, command', [
    ('/w/install/screw_kinematics/lib/screw_kinematics/bag', 'ros2 run screw_kinematics bag'),
    ('/v/bin/screw-kinematics', 'screw-kinematics bag'),
    ('/v/site-packages/screw_kinematics/__main__.py', 'screw-kinematics bag'),
    ('/v/bin/joint_state_source', 'joint_state_source'),      # which has a program of its own
    ('/v/bin/screw-kinematics', 'screw-kinematics joint_state_source'),
])
def test_a_tool_is_called_what_the_user_typed(program, command):
    assert command_of(command.split()[-1], Path(program)) == command


@pytest.mark.parametrize('given, own', [
    (['--ros-args', '-r', '__node:=x'], []),
    (['a', '--ros-args', '-p', 'use_sim_time:=true', '--', '--b'], ['a', '--b']),
    (['a', '--ros-args', '--log-level', 'info', '--', 'b', '--ros-args', '-r', 'c:=d'],
     ['a', 'b']),
])
def test_arguments_of_ros_are_left_to_ros(given, own):
    assert without_ros_arguments(given) == own


def test_a_tool_that_is_no_node_ignores_arguments_of_ros():
    shown = run('check', 'model', 'config/robots/rpr.yaml', '--ros-args', '-r', '__ns:=/cell')
    assert shown.returncode == 0 and 'rpr' in shown.stdout


def test_ctrl_c_while_a_tool_is_imported_is_no_traceback(monkeypatch):
    def interrupted(name):
        raise KeyboardInterrupt

    monkeypatch.setattr('screw_kinematics.tools.main.import_module', interrupted)
    assert main(['derive', 'arm.urdf']) == 130

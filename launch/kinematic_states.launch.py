# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Start the kinematic state publisher, for one robot by arguments or for many by a file.

ros2 launch screw_kinematics kinematic_states.launch.py tip_frame:=tool0
ros2 launch screw_kinematics kinematic_states.launch.py params_file:=robots.yaml
"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare
from screw_kinematics.pipeline.outputs import OUTPUTS
import yaml

ARGUMENTS = (
    ('params_file', '', 'parameters of the node, a YAML file; the robots are then described '
                        'there, and the arguments robot to delay are not used'),
    ('robot', 'robot', 'name of the robot, with which its topics begin'),
    ('description', '', 'model: package://, file:// or path of a .urdf, .xacro or .yaml; empty: '
                        'from the topic robot_description'),
    ('base_frame', '', 'motion is relative to it; empty: root of the model'),
    ('tip_frame', '', 'whose motion is published; empty: the only end of the model'),
    ('outputs', 'twist,accel', f'of {", ".join(OUTPUTS)}'),
    ('joint_states_topic', 'joint_states', 'or several, with commas between'),
    ('base_motion_topic', '', 'odometry of a base that drives; motion is then relative to its '
                              'frame'),
    ('frame_prefix', '', 'put before the names of frames'),
    ('delay', '0.0', 'honest delay of the estimates [s]; 0.02 makes accelerations several times '
                     'as accurate'),
    ('namespace', '', 'of the node and its topics'),
    ('use_sim_time', 'false', 'time from /clock'),
    ('autostart', 'true', 'false: a lifecycle manager configures and activates the node'),
    ('log_level', 'info', 'debug, info, warn, error or fatal'),
    ('rviz', 'false', 'start RViz, too; it shows the output markers, which is added'),
)


def generate_launch_description():
    """Return what `ros2 launch` starts; `--show-args` shows the arguments."""
    return LaunchDescription([
        *(DeclareLaunchArgument(
            name, default_value=default, description=description,
            choices=['true', 'false'] if default in ('true', 'false') else None)
          for name, default, description in ARGUMENTS),
        OpaqueFunction(function=start),
    ])


def start(context):
    """Return the actions for the arguments as they are."""
    given = {name: LaunchConfiguration(name).perform(context) for name, *_ in ARGUMENTS}
    outputs = [word.strip() for word in given['outputs'].split(',') if word.strip()]
    if given['rviz'] == 'true' and 'markers' not in outputs:
        outputs.append('markers')
    robot = given['robot']
    parameters = [given['params_file']] if given['params_file'] else [{
        'robots': [robot],
        f'{robot}.description': text(given['description']),
        f'{robot}.base_frame': text(given['base_frame']),
        f'{robot}.tip_frame': text(given['tip_frame']),
        f'{robot}.outputs': outputs,
        f'{robot}.joint_states_topic': given['joint_states_topic'].split(','),
        f'{robot}.base_motion_topic': text(given['base_motion_topic']),
        f'{robot}.frame_prefix': text(given['frame_prefix']),
        f'{robot}.estimator.delay': float(given['delay']),
    }]
    common = {name: yaml.safe_load(given[name]) for name in ('use_sim_time', 'autostart')}
    node = Node(
        package='screw_kinematics', executable='kinematic_state_publisher',
        namespace=given['namespace'], parameters=[*parameters, common], output='screen',
        arguments=['--ros-args', '--log-level', given['log_level']])
    rviz = Node(
        package='rviz2', executable='rviz2', namespace=given['namespace'],
        condition=IfCondition(given['rviz']),
        parameters=[{'use_sim_time': common['use_sim_time']}],
        remappings=[('markers', f'{robot}/markers')],
        arguments=['-d', PathJoinSubstitution([FindPackageShare('screw_kinematics'), 'config',
                                               'kinematic_states.rviz']),
                   *(['-f', given['frame_prefix'] + given['base_frame']]
                     if given['base_frame'] else [])])
    return [node, rviz]


def text(value):
    """Return a parameter that stays text, whatever it looks like."""
    return ParameterValue(value, value_type=str)

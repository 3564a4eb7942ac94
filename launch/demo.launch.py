# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Start the kinematic state publisher on a robot that is not there, and show it in RViz.

ros2 launch screw_kinematics demo.launch.py motion:=multisine rate:=500
"""
from ament_index_python.packages import get_packages_with_prefixes
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

JOINT_STATES = 'demo/joint_states'
"""Not where those of a robot come, which may be there."""

PUMA = 'package://screw_kinematics/config/robots/puma560.yaml'


def generate_launch_description():
    """Return what `ros2 launch` starts; `--show-args` shows the arguments."""
    rviz = 'true' if 'rviz2' in get_packages_with_prefixes() else 'false'
    arguments = (
        ('description', PUMA, 'model: package://, file:// or path of a .urdf, .xacro or .yaml'),
        ('base_frame', '', 'motion is relative to it; empty: root of the model'),
        ('tip_frame', '', 'whose motion is published; empty: the only end of the model'),
        ('robot', 'robot', 'name of the robot, with which its topics begin'),
        ('motion', 'paper', 'how it moves: paper, minjerk or multisine'),
        ('rate', '100.0', 'joint states per second'),
        ('delay', '0.02', 'honest delay of the estimates [s]'),
        ('namespace', '', 'of nodes and topics'),
        ('rviz', rviz, 'start RViz, too; by default where it is installed'),
    )
    given = {name: LaunchConfiguration(name) for name, *_ in arguments}
    source = Node(
        package='screw_kinematics', executable='joint_state_source', output='screen',
        namespace=given['namespace'],
        arguments=['--robot', given['description'], '--base', given['base_frame'],
                   '--tip', given['tip_frame'], '--motion', given['motion'],
                   '--rate', given['rate'], '--topic', JOINT_STATES])
    states = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(PathJoinSubstitution([
            FindPackageShare('screw_kinematics'), 'launch', 'kinematic_states.launch.py'])),
        launch_arguments={
            **{name: given[name] for name in ('description', 'base_frame', 'tip_frame', 'robot',
                                              'delay', 'namespace', 'rviz')},
            'joint_states_topic': JOINT_STATES,
            'outputs': 'pose,twist,accel,markers'}.items())
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=description)
          for name, default, description in arguments),
        source, states])

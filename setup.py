# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
from collections.abc import Set
from glob import glob
import os
from pathlib import Path
import re
import shutil
import sys
import sysconfig

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.command.install_lib import install_lib

package_name = 'screw_kinematics'
share = f'share/{package_name}'
# colcon build --symlink-install runs a link to this file from its build folder, to which it also
# links setup.cfg, packages and data files, but not the rest of the metadata.
here = Path(__file__).resolve().parent
if Path(__file__).is_symlink() and not Path('pyproject.toml').exists():
    os.symlink(here / 'pyproject.toml', 'pyproject.toml')

FLAGS = ['-g0', '-fwrapv', '-DNDEBUG', '-ffp-contract=off', '-fno-math-errno',
         '-fno-trapping-math']
"""Compiled and interpreted core have the same bits: no contraction, no reordering."""

LINK_FLAGS = ['-Wl,-s', '-lm'] if sys.platform == 'linux' else ['-lm']
"""Without symbols, which nobody looks up; with the newest exp and log of the C library: where no
library is named they are the oldest, which are slower."""

SHARED = f'{package_name}.core._shared'
"""Module in which Cython keeps, once, what all others need of it; since its version 3.2."""


class BuildCore(build_ext):
    """Translates and compiles the core; where it cannot, says so in one line and goes on."""

    def run(self) -> None:
        """Translate into the folder for temporary files, so that no source folder gets C."""
        problem = missing_tool()
        if not problem:
            self.parallel = self.parallel or os.cpu_count()
            try:
                self.forget(but=self.binaries())
                self.translate()
                super().run()
            except Exception as error:      # what a compiler's end raises differs by setuptools
                problem = str(error) or type(error).__name__
        if problem:
            print(f'{package_name}: the core will run interpreted, slower but right: {problem}',
                  file=sys.stderr)
            self.forget()
            self.extensions = []

    def translate(self) -> None:
        """Let the sources of the modules be C, which is kept for each version of Cython."""
        from Cython import __version__
        from Cython.Build import cythonize
        options = {'shared_utility_qualified_name': SHARED} if cython_shares() else {}
        translated = cythonize([Extension(e.name, e.sources) for e in self.extensions],
                               build_dir=f'{self.build_temp}/cython-{__version__}', quiet=True,
                               nthreads=self.parallel,
                               compiler_directives={'language_level': 3}, **options)
        for extension, made in zip(self.extensions, translated):
            extension.sources = made.sources

    def binaries(self) -> set[str]:
        """Return the paths of the compiled modules, from the folder in which the package is."""
        return {self.get_ext_filename(e.name) for e in self.extensions or []}

    def forget(self, but: Set[str] = frozenset()) -> None:
        """Remove what an older version compiled, or everything."""
        for folder in (self.build_lib, *(['.'] if self.inplace else [])):
            forget_binaries(folder, but)


class BuildPackage(build_py):
    """Copies the package into build/, without what an older version has left there."""

    def run(self) -> None:
        """Remove what the package has no more, nor will be compiled."""
        binaries = self.get_finalized_command('build_ext').binaries()
        forget_binaries(self.build_lib, binaries)
        for path in Path(self.build_lib, package_name).rglob('*'):
            name = path.relative_to(self.build_lib)
            if path.is_file() and not name.exists() and str(name) not in binaries:
                path.unlink()
        super().run()


class InstallPackage(install_lib):
    """Copies the package from build/ to where it is imported; colcon has an older one there."""

    def install(self) -> list[str] | None:
        """Remove the older one, whose compiled modules Python would prefer to texts."""
        shutil.rmtree(Path(self.install_dir, package_name), ignore_errors=True)
        return super().install()


def forget_binaries(folder: str, but: Set[str]) -> None:
    """
    Remove the compiled modules of the package in a folder if not all of them are to stay.

    They know each other's types, and what they share: they are of one build, or none is.
    """
    compiled = f'*{sysconfig.get_config_var("EXT_SUFFIX")}'
    found = list(Path(folder, package_name).rglob(compiled))
    if any(str(path.relative_to(folder)) not in but for path in found):
        for path in found:
            path.unlink()


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
    modules = [module(path[:-len('.pxd')].replace('/', '.'), [path[:-len('.pxd')] + '.py'])
               for path in found(f'{package_name}/*/*.pxd')]
    return [module(SHARED, []), *modules] if cython_shares() else modules


def cython_shares() -> bool:
    """Return whether Cython keeps what all modules need in one of them."""
    try:
        from Cython import __version__
    except ImportError:
        return False
    return tuple(map(int, __version__.split('.')[:2])) >= (3, 2)


def module(name: str, sources: list[str]) -> Extension:
    """Return a module to compile: loops are to be fast; decisions, which have none, small."""
    # Further flags, such as a sanitizer's, whose library is then loaded before the program.
    flags = os.environ.get('SCREW_KINEMATICS_FLAGS', '').split()
    fast = '.core.' in name and name != SHARED
    return Extension(name, sources, extra_link_args=LINK_FLAGS,
                     extra_compile_args=['-O3' if fast else '-Os', *FLAGS, *flags])


def found(pattern: str) -> list[str]:
    """Return the files of a pattern, relative to this folder as setuptools wants them."""
    return sorted(glob(pattern, root_dir=here))


def readme() -> str:
    """Return the README with links that hold on an index page too."""
    text = (here / 'README.md').read_text(encoding='utf-8')
    metadata = (here / 'pyproject.toml').read_text(encoding='utf-8')
    repository = re.findall(r'^Repository = "(.*)"', metadata, re.MULTILINE)[0]
    text = re.sub(r'(!\[[^]]*\]\()(?!https?:)', rf'\1{repository}/raw/main/', text)
    return re.sub(r'(\]\()(?!https?:|#)', rf'\1{repository}/blob/main/', text)


def executables() -> list[str]:
    """
    Return the console scripts.

    ``setup.py install`` and ``develop`` are what colcon and bloom run; setup.cfg leads their
    scripts into lib/screw_kinematics, where ``ros2 run`` looks, so each tool has its own there.
    pip builds wheels: names on everybody's path, which are few and say whose they are.
    """
    scripts = [
        f'kinematic_state_publisher = {package_name}.node.main:main',
        f'joint_state_source = {package_name}.tools.joint_state_source.main:main',
        f'screw-kinematics = {package_name}.tools.main:main',
    ]
    if {'install', 'develop'} & set(sys.argv):
        tools = [Path(path).parent.name for path in found(f'{package_name}/tools/*/main.py')]
        scripts += [f'{tool} = {package_name}.tools.{tool}.main:main' for tool in tools
                    if tool != 'joint_state_source']
    return scripts


setup(
    name=package_name,
    version='0.2.0',
    license='Apache-2.0',
    long_description=readme(),
    long_description_content_type='text/markdown',
    packages=find_packages(include=[package_name, f'{package_name}.*']),
    package_data={package_name: ['py.typed'], **{
        f'{package_name}.{Path(path).parent.name}': ['*.pxd']
        for path in found(f'{package_name}/*/*.pxd')}},
    ext_modules=core_modules(),
    cmdclass={'build_ext': BuildCore, 'build_py': BuildPackage, 'install_lib': InstallPackage},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
        (share, ['package.xml']),
        (f'{share}/config', found('config/*.*')),
        (f'{share}/config/robots', found('config/robots/*.yaml')),
        (f'{share}/launch', found('launch/*.launch.py')),
    ],
    entry_points={'console_scripts': executables()},
    python_requires='>=3.10',
    zip_safe=False,
)

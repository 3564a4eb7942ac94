# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every way of installing the package gives the same: what pip, colcon and `ros2 run` look for."""
from configparser import ConfigParser
from email import message_from_bytes
from functools import cache
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile

import pytest

ROOT = Path(__file__).parents[1]
VERSION = re.findall('<version>(.*)</version>', (ROOT / 'package.xml').read_text())[0]
ON_THE_PATH = {'screw-kinematics', 'kinematic_state_publisher', 'joint_state_source'}
TOOLS = {path.parent.name for path in (ROOT / 'screw_kinematics/tools').glob('*/main.py')}
NOT_SHIPPED = shutil.ignore_patterns(
    '.git', '.venv', 'build', 'dist', 'install', 'log', '*.egg-info', '__pycache__', '.*_cache',
    '.hypothesis', '_build', '*.so', '.coverage')

FEW = {'interpreter.pxd'}
"""Modules that are compiled here: to the ways of installing it is no matter how many there are. To
install the package, before any test, has compiled all."""

COMPILED = 'build/screw_kinematics/build'
"""Where colcon compiles in a workspace; other builds need not compile the same again."""


def run(*command, cwd, **environment):
    """Run a command that must succeed, and return what it prints."""
    path = f'{Path(sys.executable).parent}{os.pathsep}{os.environ["PATH"]}'
    # This checkout must not stand in for what is installed. What is compiled is compiled quickly.
    inherited = {name: value for name, value in os.environ.items() if name != 'PYTHONPATH'}
    done = subprocess.run([str(word) for word in command], cwd=cwd, capture_output=True, text=True,
                          env={**inherited, 'SCREW_KINEMATICS_FLAGS': '-O0', 'PATH': path,
                               **environment})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def names_in(folder):
    """Return the files below a folder, by their paths in it."""
    return {path.relative_to(folder).as_posix() for path in folder.rglob('*') if path.is_file()}


def copy(sources, folder):
    """Copy sources of which few modules will be compiled."""
    shutil.copytree(sources, folder, ignore=NOT_SHIPPED)
    for types in folder.glob('screw_kinematics/*/*.pxd'):
        if types.name not in FEW:
            types.unlink()


@pytest.fixture(scope='module')
def checkout(tmp_path_factory):
    """Copy the sources as a clone has them."""
    folder = tmp_path_factory.mktemp('sources') / 'screw_kinematics'
    shutil.copytree(ROOT, folder, ignore=NOT_SHIPPED)
    return folder


@pytest.fixture(scope='module')
def unpacked(checkout, tmp_path_factory):
    """Make the source distribution and unpack it."""
    folder = tmp_path_factory.mktemp('sdist')
    run(sys.executable, 'setup.py', '-q', 'egg_info', '-e', folder, 'sdist', '-d', folder,
        cwd=checkout)
    with tarfile.open(next(folder.glob('*.tar.gz'))) as archive:
        archive.extractall(folder)
    return next(folder.glob(f'screw*{VERSION}'))


def colcon():
    """Return the command line of colcon, from this environment or the PATH; None without one."""
    beside = Path(sys.executable).with_name('colcon')
    return str(beside) if beside.exists() else shutil.which('colcon')


@pytest.fixture(scope='module')
def workspaces(checkout, tmp_path_factory):
    """Return what builds the package into a fresh workspace, given options of colcon."""
    if colcon() is None:
        pytest.skip('colcon is not installed')

    @cache
    def build(*options):
        workspace = tmp_path_factory.mktemp('workspace')
        copy(checkout, workspace / 'src' / 'screw_kinematics')
        if options:
            shutil.copytree(build() / COMPILED, workspace / COMPILED)
        run(colcon(), 'build', '--packages-select', 'screw_kinematics', *options, cwd=workspace)
        return workspace
    return build


@pytest.fixture(scope='module')
def wheel(unpacked, request, tmp_path_factory):
    """Make the wheel from the source distribution."""
    pytest.importorskip('pip')
    folder = tmp_path_factory.mktemp('wheel')
    sources = folder / unpacked.name
    copy(unpacked, sources)
    if colcon():
        shutil.copytree(request.getfixturevalue('workspaces')() / COMPILED, sources / 'build')
    run(sys.executable, '-m', 'pip', 'wheel', '-q', '--no-deps', '--no-build-isolation', '-w',
        folder, sources, cwd=folder)
    return next(folder.glob('*.whl'))


def test_the_source_distribution_holds_the_sources(checkout, unpacked):
    assert names_in(checkout) - names_in(unpacked) <= {'.gitignore'}


def test_the_tests_of_the_source_distribution_are_found(unpacked):
    """All that look at what is around them: of a checkout, there is all that others need."""
    looking = [test for test in (unpacked / 'test').rglob('test_*.py')
               if 'parents[' in test.read_text(encoding='utf-8')]
    shown = run(sys.executable, '-m', 'pytest', '--collect-only', '-q', '-p', 'no:cacheprovider',
                '--assert=plain', *looking, cwd=unpacked)       # as none is run
    assert re.search(r'^\d+ tests collected', shown, re.MULTILINE), shown[-500:]


def test_the_wheel_says_what_it_is(wheel):
    with zipfile.ZipFile(wheel) as archive:
        metadata = message_from_bytes(next(
            archive.read(name) for name in archive.namelist() if name.endswith('/METADATA')))
    assert metadata['Version'] == VERSION
    assert metadata['Requires-Python'] == '>=3.10'
    assert 'Apache-2.0' in (metadata['License'], metadata['License-Expression'])
    assert {'ros', 'ros-kilted', 'test'} <= set(metadata.get_all('Provides-Extra'))
    assert any(url.startswith('Repository, https://') for url in metadata.get_all('Project-URL'))
    description = metadata.get_payload()
    assert '![' in description
    assert not re.findall(r'\]\((?!https?:|#)[^)]*\)', description)      # hold on an index page


def test_the_wheel_puts_few_names_on_the_path(wheel):
    with zipfile.ZipFile(wheel) as archive:
        scripts = ConfigParser()
        scripts.read_string(next(archive.read(name).decode() for name in archive.namelist()
                                 if name.endswith('/entry_points.txt')))
    assert set(scripts['console_scripts']) == ON_THE_PATH


def test_the_wheel_works_where_it_is_installed(wheel, tmp_path):
    run(sys.executable, '-m', 'pip', 'install', '-q', '--no-deps', '--no-compile', '--target',
        tmp_path, wheel, cwd=tmp_path)
    assert {f'config/{name}' for name in names_in(ROOT / 'config')} \
        <= names_in(tmp_path / 'share/screw_kinematics')
    there = {'PYTHONPATH': str(tmp_path), 'AMENT_PREFIX_PATH': str(tmp_path)}
    assert run(tmp_path / 'bin/screw-kinematics', '--version', cwd=tmp_path, **there) \
        .startswith(f'screw-kinematics {VERSION}; the core is ')
    assert 'rpr' in run(sys.executable, '-m', 'screw_kinematics', 'check', 'model',
                        'package://screw_kinematics/config/robots/rpr.yaml', cwd=tmp_path, **there)


def binary(module):
    """Return the path of a compiled module in the package."""
    return f'{module}{sysconfig.get_config_var("EXT_SUFFIX")}'


def left_of(names, checkout, folder, **environment):
    """Copy the package into a folder that has files already; return which of them are left."""
    for name in names:
        path = folder / 'screw_kinematics' / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    run(sys.executable, 'setup.py', '-q', 'build_py', '-d', folder, cwd=checkout, **environment)
    there = names_in(folder / 'screw_kinematics')
    assert '__init__.py' in there
    return {name for name in names if name in there}


def test_what_an_older_build_left_is_not_installed(checkout, tmp_path):
    compiled = binary('core/bank')      # anew in a moment, if it is not up to date
    assert left_of(['gone.py', 'models/urdf.pxd', 'core/gone.cpython-38-x86_64-linux-gnu.so',
                    'old/__init__.py', compiled], checkout, tmp_path) == {compiled}


@pytest.mark.parametrize('module', ['core/gone', 'models/urdf'])
def test_binaries_of_an_older_version_are_not_installed(module, checkout, tmp_path):
    """Be it of a module that is gone or one that is only text now: the others know its types."""
    assert not left_of([binary(module), binary('core/bank')], checkout, tmp_path)


def test_binaries_are_not_installed_where_none_are_wanted(checkout, tmp_path):
    assert not left_of([binary('core/bank')], checkout, tmp_path, SCREW_KINEMATICS_INTERPRETED='1')


def test_binaries_of_an_older_version_do_not_stay_in_the_checkout(checkout, tmp_path):
    """Python would prefer them to the texts; here nothing can be compiled."""
    sources = tmp_path / 'sources'
    shutil.copytree(checkout, sources)
    old = sources / 'screw_kinematics' / binary('models/urdf')
    old.touch()
    run(sys.executable, 'setup.py', '-q', 'build_ext', '--inplace', cwd=sources, CC='no-compiler')
    assert not old.exists()


def test_a_version_is_installed_in_the_place_of_an_older_one(checkout, tmp_path):
    """As colcon does, again and again into one folder."""
    built, installed = tmp_path / 'built', tmp_path / 'installed'
    old = installed / 'screw_kinematics' / binary('models/urdf')
    old.parent.mkdir(parents=True)
    old.touch()
    run(sys.executable, 'setup.py', '-q', 'build_py', '-d', built,
        'install_lib', '--skip-build', '-b', built, '-d', installed, cwd=checkout)
    assert not old.exists() and old.with_name('urdf.py').exists()


@pytest.fixture(scope='module', params=[(), ('--symlink-install',)], ids=['copies', 'links'])
def prefix(request, workspaces):
    """Build the package into a workspace and return its install prefix."""
    return workspaces(*request.param) / 'install' / 'screw_kinematics'


def test_index_marker_leads_to_the_prefix(prefix):
    marker = prefix / 'share/ament_index/resource_index/packages/screw_kinematics'
    assert marker.is_file()
    assert (prefix / 'share/screw_kinematics/package.xml').is_file()


def test_exactly_one_executable_of_each_name(prefix):
    """Find them as `ros2 run` does."""
    for name in {*TOOLS, *ON_THE_PATH}:
        found = [path for path in (prefix / 'lib/screw_kinematics').rglob(name)
                 if path.is_file() and os.access(path, os.X_OK)]
        assert len(found) == 1, name
        assert found[0].read_text().startswith('#!')
    assert not (prefix / 'bin').exists()


def test_data_files_are_installed(prefix):
    for folder in ('config', 'launch'):
        assert names_in(prefix / 'share/screw_kinematics' / folder) == names_in(ROOT / folder)


def test_executables_run_from_the_workspace(prefix):
    run_in = f'source {prefix.parent}/setup.bash && {prefix}/lib/screw_kinematics/'
    assert run('bash', '-c', f'{run_in}demo --version', cwd=prefix) \
        .startswith(f'ros2 run screw_kinematics demo {VERSION}; the core is ')
    shown = run('bash', '-c', f'{run_in}check model '
                'package://screw_kinematics/config/robots/puma560.yaml', cwd=prefix)
    assert 'puma560' in shown


def test_the_demo_runs_from_the_workspace(prefix):
    pytest.importorskip('rclpy')
    shown = run('bash', '-c', f'source {prefix.parent}/setup.bash && '
                f'{prefix}/lib/screw_kinematics/demo --once', cwd=prefix)
    assert 'motion of tool relative to base' in shown

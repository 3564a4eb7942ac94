# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Building the node in C++, where a compiler and ROS's headers are found."""
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig
import tempfile

from screw_kinematics import models

from .robot import BASE, JOINTS, TIP, URDF

SOURCE = Path(__file__).with_name('native_node.cpp')
MESSAGES = ('sensor_msgs', 'geometry_msgs')
LIBRARIES = ('rcl', 'rcutils', 'rmw_fastrtps_cpp', 'rosidl_runtime_c', *(
    f'{package}__rosidl_{part}_c' for package in MESSAGES
    for part in ('generator', 'typesupport')))


def build() -> Path | None:
    """Return the built node; None, with one line that says why, where that is not possible."""
    prefix = ros_prefix()
    if shutil.which('g++') is None or shutil.which('gcc') is None:
        print('without the node in C++: no g++ and gcc found', file=sys.stderr)
        return None
    if prefix is None:
        print('without the node in C++: no headers of rcl found', file=sys.stderr)
        return None
    place = Path(tempfile.mkdtemp(prefix='native_node_'))
    program = models.load(URDF, BASE, TIP).compile(('twist', 'accel'))
    names = ', '.join(f'"{joint}"' for joint in JOINTS)
    for name, text in (
            ('tip.c', program.source('c', 'tip')), ('tip.h', program.source('c_header', 'tip')),
            ('joints.h', f'static const char * const JOINTS[] = {{{names}}};\n'
                         f'static const char * const BASE = "{BASE}";\n')):
        (place / name).write_text(text)
    # Of a wheel the libraries of messages want that of Python; elsewhere it does no harm.
    python = sysconfig.get_config_var('LIBDIR')
    version = sysconfig.get_config_var('LDVERSION')
    run('gcc', '-O3', '-c', place / 'tip.c', '-o', place / 'tip.o')
    run('g++', '-O3', '-std=c++17', SOURCE, place / 'tip.o', '-o', place / 'native_node',
        f'-I{place}', *(f'-I{folder}' for folder in (prefix / 'include').iterdir()),
        f'-L{prefix / "lib"}', f'-Wl,-rpath,{prefix / "lib"}', '-Wl,--allow-shlib-undefined',
        *(f'-l{name}' for name in LIBRARIES),
        '-Wl,--no-as-needed', f'-L{python}', f'-Wl,-rpath,{python}', f'-lpython{version}')
    return place / 'native_node'


def ros_prefix() -> Path | None:
    """Return where ROS is installed with its headers."""
    places = [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    return next((Path(place) for place in places
                 if place and (Path(place) / 'include/rcl/rcl/rcl.h').exists()), None)


def run(*command: object) -> None:
    """Run a compiler."""
    subprocess.run([str(word) for word in command], check=True)

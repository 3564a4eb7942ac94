# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Coverage-guided fuzzing of everything that reads bytes and numbers from others.

Run from the root of the source tree, ``python -m benchmark.fuzz urdf --seconds 60``; needs
``pip install atheris``, and what the tests need. Whatever the bytes, a reader returns a result or
raises an error of the package, within a second and 512 MB (recordings: ``--memory 2000``); the
first input that breaks this rule stops the run with its traceback and is written to a file
``crash-...``. ``benchmark/sanitize.sh`` runs the fuzzers on a core that is built with sanitizers.
"""
from __future__ import annotations

import argparse
from array import array
from collections.abc import Callable
from pathlib import Path
import re
import sys
import tempfile
import time

import numpy as np

try:
    import atheris
except ImportError:
    sys.exit('fuzzing needs the package atheris; install it with: pip install atheris')

with atheris.instrument_imports(include=['screw_kinematics']):
    from screw_kinematics.core.interpreter import Interpreter
    from screw_kinematics.errors import ScrewKinematicsError
    from screw_kinematics.messages.joint_state import JointStateDecoder
    from screw_kinematics.models import load
    from screw_kinematics.models.guarded_yaml import read_yaml
    from screw_kinematics.models.model_file import robot_from_data
    from screw_kinematics.models.urdf import load_urdf
    from screw_kinematics.motion import MotionEstimator
    from screw_kinematics.node.foreign_encoding import read_by_middleware
    from screw_kinematics.pipeline.parameter_file import read_robots
    from screw_kinematics.recordings.joint_table import TableFormat
    from screw_kinematics.recordings.recording import Recording
    from screw_kinematics.recordings.sources import opened

from benchmark.recordings.recordings import JOINTS, write

CONFIG = Path(__file__).parents[1] / 'config'
ROBOTS = CONFIG / 'robots'

URDF = b"""<?xml version="1.0"?>
<robot name="r"><link name="a"/><link name="b"/><link name="c"><visual/></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="1 2 3" rpy="0 1 2"/><axis xyz="0 0 1"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/>
<mimic joint="j" multiplier="2" offset=".1"/></joint></robot>"""

XACRO = b"""<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="length" default="2"/>
<xacro:property name="l" value="$(arg length)"/><xacro:macro name="part" params="name *origin">
<link name="${name}"/><joint name="j_${name}" type="revolute"><parent link="a"/>
<child link="${name}"/><xacro:insert_block name="origin"/><axis xyz="0 0 1"/></joint></xacro:macro>
<link name="a"/><xacro:if value="${l > 1}"><xacro:part name="b"><origin xyz="0 0 ${l/2}"/>
</xacro:part></xacro:if></robot>"""

# One joint 'q' in the frame '', position 1.0 and no velocity or effort.
JOINT_STATE = bytes.fromhex(
    '00010000' '0100000002000000' '0100000000000000'
    '01000000' '0200000071000000' '01000000' '000000000000f03f' '00000000' '00000000')


def read_urdf(data: bytes) -> object:
    """Read a robot description."""
    return load_urdf(data)


def read_model(data: bytes) -> object:
    """Read a model file."""
    return robot_from_data(read_yaml('fuzz', data), 'fuzz', 'fuzz')


def from_file(ending: str, read: Callable[[Path], object]) -> Callable[[bytes], object]:
    """Return a reader of bytes that puts them into a file."""
    def through_file(data: bytes) -> object:
        """Read bytes as a file."""
        with tempfile.TemporaryDirectory(dir='/dev/shm') as folder:
            file = Path(folder, 'fuzz').with_suffix(ending)
            file.write_bytes(data)
            return read(file)
    return through_file


def read_recording(file: Path) -> object:
    """Read all joint states of a bag or a table."""
    with opened(str(file), TableFormat()) as recording:
        if isinstance(recording, Recording):
            return list(recording.samples({'/joint_states'}))
        return list(recording.samples(dict.fromkeys(JOINTS, 'revolute')))


def recordings(form: str) -> list[bytes]:
    """Return a recording of some samples."""
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder), 0, 5, form)
        return [file.read_bytes() for file in ([path] if path.is_file() else path.iterdir())
                if file.suffix != '.yaml']


def read_joint_state(data: bytes) -> object:
    """Decode a message twice: by its own layout, then by the layout remembered."""
    decoder = JointStateDecoder(read_by_middleware)
    decoder.decode(data)
    return decoder.decode(data)


def run_program(data: bytes) -> object:
    """Run whatever code the interpreter of programs accepts, on one sample and on a batch."""
    if len(data) < 4:
        return None
    n_rows, n_inputs, n_constants, n_outputs = data[:4]
    words = array('Q', data[4:len(data) - (len(data) - 4) % 8])
    outputs, code = words[:n_outputs % 8], words[n_outputs % 8:]
    try:
        program = Interpreter(code, n_rows, n_inputs, array('d', [0.5] * n_constants), outputs,
                              n_inputs, [('all', slice(None))], np.empty)
    except ValueError:
        return None
    none, many = np.empty((70, 0)), np.ones((70, n_inputs))
    program.batch(0, 70, np.empty((70, len(outputs))), many, none, none, none, none)
    return program.evaluate([1.0] * n_inputs), program.sample((many[0],))


def estimate_motion(data: bytes) -> object:
    """Let an estimator of two joints take samples of any numbers at any times."""
    estimator = MotionEstimator(2, delay=0.02 * (data[:1] > b'\x80'))
    numbers = array('d', data[1:len(data) - (len(data) - 1) % 8])
    stamp = 0.0
    for k in range(0, len(numbers) - 4, 5):
        stamp += numbers[k]
        velocity = numbers[k + 3:k + 5]
        estimator.update(stamp, np.array(numbers[k + 1:k + 3]),
                         np.array(velocity) if velocity[0] == velocity[0] else None)
    return estimator


TARGETS: dict[str, tuple[Callable[[bytes], object], list[bytes]]] = {
    'urdf': (read_urdf, [URDF]),
    'model': (read_model, [path.read_bytes() for path in ROBOTS.glob('*.yaml')]),
    'xacro': (from_file('.xacro', load), [XACRO]),
    'parameters': (from_file('.yaml', read_robots),
                   [path.read_bytes() for path in CONFIG.glob('*.yaml')]),
    'mcap': (from_file('.mcap', read_recording), recordings('mcap') + recordings('mcap_zstd')),
    'sqlite3': (from_file('.db3', read_recording), recordings('sqlite3')),
    'ros1': (from_file('.bag', read_recording), recordings('ros1')),
    'csv': (from_file('.csv', read_recording), recordings('csv')),
    'parquet': (from_file('.parquet', read_recording), recordings('parquet')),
    'joint_state': (read_joint_state, [JOINT_STATE]),
    'program': (run_program, [bytes([4, 2, 1, 1]) + array('Q', [
        3, 1 << 16, 3 | 1 << 32 | 2 << 48, 5 | 1 << 16, 3 | 1 << 16 | 3 << 32]).tobytes()]),
    'motion': (estimate_motion, [b'\0' + array('d', [
        x for k in range(20) for x in (0.001, k * 0.01, 0.0, 10.0, 0.0)]).tobytes()]),
}


def main() -> None:
    """Fuzz one reader for some time; the last lines say how many inputs were tried."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').strip().splitlines()[0])
    parser.add_argument('target', choices=TARGETS)
    parser.add_argument('--seconds', type=int, default=60)
    parser.add_argument('--memory', type=int, default=512, metavar='MB',
                        help='limit (default: 512); sanitizers need some 2000 for themselves')
    arguments = parser.parse_args()
    read, seeds = TARGETS[arguments.target]

    def guarded(data: bytes) -> None:
        start = time.process_time()
        try:
            read(data)
        except ScrewKinematicsError:
            pass
        # Of this process alone: on a busy machine the fuzzer's own clock gives false alarms.
        if time.process_time() - start > 1:
            raise RuntimeError('took more than a second')

    # A dictionary must not be empty.
    words = {'_'}.union(*(re.findall('[a-z_]+', seed.decode('latin-1')) for seed in seeds))
    with tempfile.TemporaryDirectory() as folder:
        corpus, dictionary = Path(folder, 'corpus'), Path(folder, 'words')
        corpus.mkdir()
        for number, seed in enumerate(seeds):
            (corpus / str(number)).write_bytes(seed)
        dictionary.write_text(''.join(f'"{word}"\n' for word in sorted(words)))
        atheris.Setup([sys.argv[0], str(corpus), f'-dict={dictionary}', '-timeout=60',
                       f'-max_total_time={arguments.seconds}', f'-rss_limit_mb={arguments.memory}',
                       '-print_final_stats=1'], guarded)
        atheris.Fuzz()


if __name__ == '__main__':
    main()

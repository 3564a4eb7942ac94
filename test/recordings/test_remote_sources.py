# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings in an object store and behind ssh, served by processes of their own."""
from contextlib import contextmanager
import subprocess
import sys

import pyarrow.parquet
import pytest

from screw_kinematics.recordings.sources import find_sources
from screw_kinematics.tools.bag import main as bag
from support import recordings as rec

fsspec = pytest.importorskip('fsspec')
PUMA = str(rec.ROBOTS / 'puma560.yaml')

S3_SERVER = """
import sys
from moto.server import ThreadedMotoServer
server = ThreadedMotoServer('127.0.0.1', 0, verbose=False)
server.start()
print(server.get_host_and_port()[1], flush=True)
sys.stdin.read()
"""

GS_SERVER = """
import socket
import sys
from gcp_storage_emulator.server import create_server
with socket.create_server(('127.0.0.1', 0)) as free:
    port = free.getsockname()[1]
create_server('127.0.0.1', port, in_memory=True, default_bucket='lab').start()
print(port, flush=True)
sys.stdin.read()
"""

SSH_SERVER = """
import asyncio
import sys
import asyncssh

class Server(asyncssh.SSHServer):
    def begin_auth(self, username):
        return True
    def password_auth_supported(self):
        return True
    def validate_password(self, username, password):
        return password == 'secret'

async def serve():
    server = await asyncssh.listen(
        '127.0.0.1', 0, server_factory=Server,
        server_host_keys=[asyncssh.generate_private_key('ssh-ed25519')],
        sftp_factory=lambda connection: asyncssh.SFTPServer(connection, chroot=sys.argv[1]))
    print(server.get_port(), flush=True)
    await asyncio.to_thread(sys.stdin.read)

asyncio.run(serve())
"""


@pytest.fixture(scope='module')
def lab(tmp_path_factory):
    """Return a folder with a bag, which is a folder, and a file of ROS 1."""
    folder = tmp_path_factory.mktemp('remote') / 'lab'
    folder.mkdir()
    rec.write_bag(folder / 'whole', rec.samples(300))
    rec.write_ros1_bag(folder / 'run.bag', 310)
    return folder


@contextmanager
def serving(text, *arguments):
    """Run a server that ends with its input; yield its port."""
    server = subprocess.Popen([sys.executable, '-c', text, *arguments], text=True,
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        yield int(server.stdout.readline())
    finally:
        server.kill()
        server.communicate()


@pytest.fixture(scope='module')
def bucket(lab):
    """Serve the folder as s3://lab/day; yield the environment that leads there."""
    s3fs = pytest.importorskip('s3fs')
    pytest.importorskip('moto.server')
    with serving(S3_SERVER) as port, pytest.MonkeyPatch.context() as patch:
        patch.setenv('AWS_ENDPOINT_URL', f'http://127.0.0.1:{port}')
        patch.setenv('AWS_ACCESS_KEY_ID', 'key')
        patch.setenv('AWS_SECRET_ACCESS_KEY', 'secret')
        patch.setenv('AWS_DEFAULT_REGION', 'us-east-1')
        s3fs.S3FileSystem.clear_instance_cache()
        files = s3fs.S3FileSystem()
        files.mkdir('lab')
        files.put(str(lab), 'lab/day', recursive=True)
        yield 's3://lab/day'
    s3fs.S3FileSystem.clear_instance_cache()


@pytest.fixture(scope='module')
def google_bucket(lab):
    """Serve the folder as gs://lab/day; yield that."""
    pytest.importorskip('gcp_storage_emulator')
    with serving(GS_SERVER) as port, pytest.MonkeyPatch.context() as patch:
        patch.setenv('STORAGE_EMULATOR_HOST', f'http://127.0.0.1:{port}')
        patch.setenv('GCSFS_EXPERIMENTAL_ZB_HNS_SUPPORT', 'false')      # asks Google itself
        gcsfs = pytest.importorskip('gcsfs')
        files = gcsfs.GCSFileSystem(token='anon')
        for file in lab.rglob('*.*'):
            files.pipe_file(f'lab/day/{file.relative_to(lab)}', file.read_bytes())
        yield 'gs://lab/day'
    gcsfs.GCSFileSystem.clear_instance_cache()


@pytest.fixture(scope='module')
def host(lab):
    """Serve the folder over ssh; yield its URL."""
    pytest.importorskip('asyncssh')
    pytest.importorskip('paramiko')
    with serving(SSH_SERVER, str(lab.parent)) as port:
        yield f'ssh://me:secret@127.0.0.1:{port}/lab'


def run(place, output, *more):
    return bag.main([str(place), '--robot', PUMA, '--output', str(output), *more])


def check_states(place, lab, folder, processes):
    """Assert that what is made of recordings elsewhere is what is made of them here."""
    assert run(lab, folder / 'here', '--processes', '1') == 0
    assert run(place, folder / 'there', '--processes', processes) == 0
    parts = sorted((folder / 'here').rglob('*.parquet'))
    assert [part.stem for part in parts] == ['run', 'whole']
    for part in parts:
        there = folder / 'there' / part.relative_to(folder / 'here')
        assert pyarrow.parquet.read_table(part).equals(pyarrow.parquet.read_table(there))


@pytest.mark.parametrize('processes', ['1', '2'])
def test_an_object_store(bucket, lab, tmp_path, processes):
    check_states(bucket, lab, tmp_path, processes)


def test_another_object_store(google_bucket, lab, tmp_path, capsys):
    check_states(google_bucket, lab, tmp_path, '2')
    assert run(google_bucket, tmp_path / 'there', '--processes', '1') == 0
    assert '2 of 2 recordings are done and unchanged' in capsys.readouterr().out
    assert 'gs://no-bucket/day: ' in failure('gs://no-bucket/day', tmp_path, capsys)
    assert 'gs://lab/night.mcap: ' in failure('gs://lab/night.mcap', tmp_path, capsys)


def test_what_has_changed_in_an_object_store_is_done_again(bucket, lab, tmp_path, capsys):
    assert run(bucket, tmp_path / 'out', '--processes', '1') == 0
    assert run(bucket, tmp_path / 'out', '--processes', '1') == 0
    assert '2 of 2 recordings are done and unchanged' in capsys.readouterr().out
    files = fsspec.filesystem('s3')
    files.pipe_file('lab/day/run.bag', (lab / 'run.bag').read_bytes()[:-1])
    try:
        assert run(bucket, tmp_path / 'out', '--processes', '1') == 1
        assert '1 of 2 recordings are done and unchanged' in capsys.readouterr().out
    finally:
        files.put(str(lab / 'run.bag'), 'lab/day/run.bag')


def test_ssh(host, lab, tmp_path, capsys):
    check_states(host, lab, tmp_path, '1')
    assert [source.name for source in find_sources([host + '/*.bag'])] == ['run']


def failure(place, tmp_path, capsys):
    """Return the one line that a place that cannot be read leads to."""
    assert run(place, tmp_path / 'out.csv') == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1 and 'secret' not in error
    return error


def test_places_in_an_object_store_that_are_not_there(bucket, tmp_path, capsys):
    assert 's3://no-bucket/day: ' in failure('s3://no-bucket/day', tmp_path, capsys)
    assert 's3://lab/night.mcap: ' in failure('s3://lab/night.mcap', tmp_path, capsys)


def test_no_credentials(bucket, tmp_path, capsys, monkeypatch):
    s3fs = pytest.importorskip('s3fs')
    for name in ('AWS_ACCESS_KEY_ID', 'AWS_SECRET_ACCESS_KEY'):
        monkeypatch.delenv(name)
    monkeypatch.setenv('AWS_EC2_METADATA_DISABLED', 'true')
    monkeypatch.setenv('HOME', str(tmp_path))
    s3fs.S3FileSystem.clear_instance_cache()
    try:
        assert 's3://lab/day: NoCredentialsError' in failure(bucket, tmp_path, capsys)
    finally:
        s3fs.S3FileSystem.clear_instance_cache()


def test_a_password_that_is_wrong_is_not_shown(host, tmp_path, capsys):
    place = host.replace('secret', 'secret-but-wrong')
    assert 'ssh://me:***@127.0.0.1' in failure(place, tmp_path, capsys)
    assert 'ssh://me:***@127.0.0.1' in failure(host + '/night', tmp_path, capsys)


@pytest.mark.parametrize('place, package', [
    ('s3://lab/day', 's3fs'), ('gs://lab/day', 'gcsfs'), ('ssh://host/day', 'paramiko')])
def test_the_package_that_is_missing_is_named(place, package, tmp_path):
    found = subprocess.run(
        [sys.executable, '-c', 'import sys\nfor name in ("sshfs", "paramiko", "s3fs", "gcsfs"):\n'
         '    sys.modules[name] = None\nfrom screw_kinematics.tools.bag.main import main\n'
         'sys.exit(main(sys.argv[1:]))', place, '--robot', PUMA, '--output', str(tmp_path / 'x')],
        capture_output=True, text=True)
    assert found.returncode == 2 and found.stderr.count('\n') == 1, found.stderr
    assert package in found.stderr.replace('sshfs', 'paramiko')

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The view: what is drawn are the states, and the page works in a browser."""
from contextlib import closing
from io import BytesIO
from itertools import islice
import re
import shutil
import socket
import sys
import time
import urllib.request

import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.errors import MissingExtraError, ParameterError, ScrewKinematicsError
from screw_kinematics.pipeline.parameter_file import robot_settings
from screw_kinematics.screws import screw_of_twist
from screw_kinematics.tools import robot_options
from screw_kinematics.tools.stamping import stampings
from screw_kinematics.tools.view import main as view
from screw_kinematics.tools.view.motion import ShownMotion, Snapshot, tip_covariance

pytest.importorskip('viser')

from screw_kinematics.tools.view.meshes import load_meshes    # noqa: E402
from screw_kinematics.tools.view.page import open_server, Page    # noqa: E402
from screw_kinematics.tools.view.recorded import recorded_motions    # noqa: E402
from screw_kinematics.tools.view.scene import round_scale, vectors    # noqa: E402

ROBOT = models.load(robot_options.PUMA)
MOTION = robot_options.motion(ROBOT, 'multisine')
URDF = """<robot name="two"><link name="base"/><link name="arm"><visual>
<geometry><box size="0.4 0.1 0.1"/></geometry></visual></link><link name="tip"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="fixed" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="1 0 0"/>
</joint></robot>"""


def shown(robot=ROBOT, motion=MOTION, seconds=6.0, rate=50.0, name='puma'):
    """Return a motion that is known exactly, as it is shown."""
    found = ShownMotion(name, robot)
    for t in np.arange(0.0, seconds, 1 / rate):
        q, qd, qdd = motion.derivatives(t, 2)
        state = robot.state(q, qd, qdd)
        exact = np.array([state.classical(1), state.classical(2)])
        found.snapshots.append(Snapshot(t, q, robot.skeleton(q), state.pose, *exact,
                                        np.diag([4e-4, 1e-4, 0.0]), 1.1 * exact))
    return found


@pytest.fixture
def server():
    """Return a server at a free port of this machine."""
    with closing(socket.socket()) as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    server = open_server('127.0.0.1', port)
    yield server
    server.stop()


@pytest.mark.parametrize('host, port, message', [
    ('127.0.0.1', 99999, "parameter 'port' is 99999; allowed: 0 to 65535"),
    ('192.0.2.1', 8080, 'nobody can answer there: .*192.0.2.1'),    # of nobody, by RFC 5737
])
def test_an_address_at_which_nobody_can_answer(host, port, message):
    with pytest.raises(ScrewKinematicsError, match=message):
        open_server(host, port)


def test_arrows_are_the_states_in_their_scales(server):
    motion = shown()
    page = Page(server, [motion])
    page.panel.set_playing(False)
    for t in (0.0, 1.3, 4.2):
        page.panel.time.value = t
        page.step(0.01)
        snapshot, scene = motion.at(page.time), page.scenes[0]
        assert abs(snapshot.time - t) < 0.021
        for name, value in vectors(snapshot.twist, snapshot.accel).items():
            begin, end = scene.arrow(name)
            np.testing.assert_allclose(begin, snapshot.pose[:3, 3], rtol=1e-6)
            np.testing.assert_allclose(end - begin, scene.scales[name] * value, atol=1e-6)
            true_begin, true_end = scene.arrow(f'true {name}')
            np.testing.assert_allclose(true_end - true_begin, 1.1 * (end - begin), atol=1e-6)
        axis = np.diff(scene.arrow('screw axis'), axis=0)[0]
        np.testing.assert_allclose(
            np.cross(axis, screw_of_twist(snapshot.twist).axis), 0, atol=1e-6)


def test_playing_pausing_and_winding(server):
    page = Page(server, [shown(seconds=4.0)])
    page.step(0.5)
    assert page.time == pytest.approx(0.5)
    assert page.panel.time.value == pytest.approx(0.5, abs=5e-3)
    page.panel.speed.value = '1/4'
    page.step(0.4)
    assert page.time == pytest.approx(0.6)
    page.panel.set_playing(False)
    page.step(1.0)
    assert page.time == pytest.approx(0.6) and page.panel.play.label == 'play'
    page.panel.time.value = 3.0
    page.step(1.0)
    assert page.time == pytest.approx(3.0)
    page.panel.set_playing(True)
    page.panel.speed.value = '2'
    page.step(0.6)
    assert page.time == pytest.approx(0.2, abs=0.05)     # from the beginning again


def test_what_is_hidden_is_not_drawn(server):
    page = Page(server, [shown()])
    page.step(1.0)
    scene = page.scenes[0]
    names = {'a': 'a', 'trail': 'trail', 'screw': 'screw axis', 'truth': 'true v', 'frames': 'tip'}
    for box, node in names.items():
        assert scene._nodes[node].visible
        page.panel.shown[box].value = False
    page.step(0.1)
    for node in names.values():
        assert not scene._nodes[node].visible


def test_several_robots_stand_beside_each_other(server):
    rpr = models.load(str(robot_options.PUMA).replace('puma560', 'rpr'))
    delta = models.load(str(robot_options.PUMA).replace('puma560', 'delta'))
    motions = [shown(), shown(rpr, robot_options.motion(rpr, 'paper'), 1.0, name='rpr'),
               shown(delta, robot_options.motion(delta, 'paper'), 0.5, name='delta')]
    page = Page(server, motions)
    page.step(0.3)
    middles = np.array([scene.middle for scene in page.scenes])
    assert np.all(np.diff(middles[:, 1]) > 0.3)
    page.panel.robot.value = 'rpr'
    page.step(1.0)
    assert '**rpr**' in page.panel._about.content


def test_the_panel_says_frames_scales_doubts_and_errors(server):
    motion = shown()
    motion.doubts = ['3 of 400 samples not used: implausible_jump']
    page = Page(server, [motion])
    page.step(1.0)
    panel = page.panel
    assert 'motion of `tool` relative to `base`' in panel._about.content
    assert 'skeleton only' in panel._about.content
    assert f'{100 * page.scenes[0].scales["v"]:.3g} cm for 1 m/s' in panel._legend.content
    assert 'implausible_jump' in panel._doubts.content
    assert 'error of a:' in panel._numbers.content
    drawn = panel._series['a'].data
    np.testing.assert_allclose(drawn[4], 1.1 * drawn[1])     # the truth beside it


def test_bodies_move_with_the_joints(server):
    pytest.importorskip('yourdfpy')
    robot = models.load_urdf(URDF)
    meshes, why = load_meshes(URDF, robot)
    assert meshes is not None, why
    meshes.add_to(server, '/two')
    meshes.move(np.array([np.pi / 2]))
    arm = next(frame for frame in meshes._bodies._joint_frames if frame.name.endswith('arm'))
    np.testing.assert_allclose(arm.wxyz, [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=1e-12)
    seen_from_tip = models.load_urdf(URDF, 'tip', 'base')
    turned, _ = load_meshes(URDF, seen_from_tip)
    turned.add_to(server, '/turned')
    turned.move(np.array([np.pi / 2]))
    # The base seen from the tip: one metre behind it, turned back.
    np.testing.assert_allclose(turned._frame.position, [-1, 0, 0], atol=1e-12)


@pytest.mark.parametrize('name', ['box.stl', 'package://some_arm/meshes/box.stl'])
def test_meshes_are_found_beside_the_description(tmp_path, name):
    """By relative names, and in a package that is not installed but copied."""
    trimesh = pytest.importorskip('trimesh')
    folder = tmp_path / 'some_arm'
    for place in (folder / 'urdf', folder / 'meshes'):
        place.mkdir(parents=True)
        trimesh.creation.box().export(place / 'box.stl')
    file = folder / 'urdf' / 'arm.urdf'
    file.write_text(URDF.replace('<box size="0.4 0.1 0.1"/>', f'<mesh filename="{name}"/>'))
    meshes, why = load_meshes(str(file), models.load(file))
    assert meshes is not None, why
    for copy in folder.rglob('box.stl'):
        copy.unlink()
    meshes, why = load_meshes(str(file), models.load(file))
    assert meshes is None and 'box.stl' in why


@pytest.mark.parametrize('description, why', [
    (robot_options.PUMA, 'the model has none'), ('nowhere.urdf', 'no such file'),
    ('<robot/>', 'Error|error|none'), ('<robot name="r"><link name="a"/></robot>', 'has none')])
def test_without_bodies_there_is_a_reason(description, why):
    pytest.importorskip('yourdfpy')
    meshes, found = load_meshes(description, ROBOT)
    assert meshes is None and re.search(why, found)


@pytest.mark.parametrize('largest, length, scale', [
    (3.0, 0.4, 0.1), (0.4, 0.4, 1.0), (1.0, 0.5, 0.5), (1e-3, 1.0, 1000.0), (0.0, 0.7, 0.7)])
def test_scales_are_round(largest, length, scale):
    assert round_scale(largest, length) == pytest.approx(scale)


def test_live_states_are_kept_for_a_while():
    motion, source = ShownMotion('puma', ROBOT), shown(seconds=30.0, rate=10.0)
    for snapshot in source.snapshots:
        motion.append(snapshot, keep=8.0)
    assert 8.0 <= motion.end - motion.snapshots[0].time <= 9.7
    assert [s.time for s in motion.window(motion.end, 1.0)] == [
        s.time for s in source.snapshots[-10:]]


def test_the_tip_s_covariance_is_that_of_many_tries():
    q, rng = np.full(6, 0.3), np.random.default_rng(0)
    sigma = np.array([0.1, 0.2, 0.3, 0.05, 0.2, 0.4])
    qdd = sigma * rng.normal(size=(40_000, 6))
    tries = ROBOT.state(np.tile(q, (len(qdd), 1)), 0 * qdd, qdd).classical(2)[:, 3:]
    covariance = tip_covariance(ROBOT.jacobian(q), sigma**2)
    np.testing.assert_allclose(covariance, np.cov(tries.T), atol=2e-2 * covariance.max())


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    """Return a bag of 5 s."""
    pytest.importorskip('rosbags')
    from support import recordings
    return recordings.write_bag(tmp_path_factory.mktemp('view') / 'run', recordings.samples(1000))


def test_a_recording_is_shown_as_it_was(recording):
    settings = robot_settings('puma', {'description': robot_options.PUMA})
    motion, = recorded_motions(str(recording), [settings], '')
    assert 55 * 5 < len(motion.snapshots) <= 60 * 5 + 1 and motion.end == pytest.approx(5, abs=.05)
    for snapshot in motion.snapshots[20:-20:40]:
        state = ROBOT.state(*MOTION.derivatives(snapshot.time, 2))
        np.testing.assert_allclose(snapshot.pose, state.pose, atol=1e-4)
        np.testing.assert_allclose(snapshot.accel, state.classical(2), atol=0.05)
        assert np.linalg.eigvalsh(snapshot.covariance).min() > -1e-12


def test_of_a_folder_of_recordings_one_is_to_be_named(recording, tmp_path):
    for name in 'ab':
        shutil.copytree(recording, tmp_path / f'copy_{name}')
    settings = [robot_settings('puma', {'description': robot_options.PUMA})]
    with pytest.raises(ParameterError, match="folder of 2, such as .*copy_a"):
        recorded_motions(str(tmp_path), settings, '')


def test_rerun_files(recording, tmp_path):
    pytest.importorskip('rerun')
    output = tmp_path / 'new' / 'folder' / 'run.rrd'
    arguments = [str(recording), '--robot', robot_options.PUMA, '--output', str(output)]
    assert view.main(arguments) == 0
    assert output.read_bytes()[:4] == b'RRF2' and output.stat().st_size > 50_000
    assert view.main(arguments) == 2        # it is there already


@pytest.mark.parametrize('arguments, message', [
    ([], 'allowed: a recording or --live'),
    (['run', '--live'], 'allowed: a recording or --live'),
    (['--live', '--output', 'run.rrd'], "'output' is 'run.rrd'; allowed: with a recording"),
    (['run', '--output', 'run.txt'], "'output' is 'run.txt'; allowed: a new file ending in .rrd"),
    (['--live', '--seconds', 'nan'], "'seconds' is nan; allowed: more than 0"),
    (['--live', '--namespace', '1 2'], "'namespace' is '1 2'; allowed: letters, digits"),
    (['nowhere', '--robot', robot_options.PUMA], 'nowhere: no recording there')])
def test_errors_are_one_line(capsys, arguments, message):
    assert view.main(arguments) == 2
    error = capsys.readouterr().err
    assert message in error and error.count('\n') == 1


def test_viser_is_an_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, 'viser', None)
    with pytest.raises(MissingExtraError, match=r"'screw_kinematics\[view\]'"):
        open_server('127.0.0.1', 0)


def test_nobody_but_this_machine_is_answered(server):
    port = server.get_port()
    page = urllib.request.urlopen(f'http://127.0.0.1:{port}', timeout=30).read()
    assert b'<html' in page.lower()
    for *_, address in socket.getaddrinfo(socket.gethostname(), port, socket.AF_INET):
        if not address[0].startswith('127.'):
            with pytest.raises(OSError):
                socket.create_connection(address, timeout=2).close()


@pytest.fixture(params=[(1100, 700), (720, 560)], ids=['wide', 'narrow'])
def browser_page(request):
    """Return a page of headless Chromium."""
    chromium = shutil.which('chromium') or shutil.which('google-chrome')
    if chromium is None:
        pytest.skip('Chromium is not installed')
    api = pytest.importorskip('playwright.sync_api')
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=[
            '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
            '--enable-unsafe-swiftshader'])
        width, height = request.param
        page = browser.new_page(viewport={'width': width, 'height': height})
        page.set_default_timeout(120_000)     # drawn without a GPU, on a busy machine
        yield page
        browser.close()


def test_the_page_in_a_browser(server, browser_page):
    """It loads and draws; winding in the browser moves the arrows; the button pauses."""
    page = Page(server, [shown()])
    browser_page.goto(f'http://127.0.0.1:{server.get_port()}', timeout=120_000)

    def run(condition, seconds=120.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end
            page.step(0.02)
            browser_page.wait_for_timeout(20)

    run(lambda: server.get_clients() and browser_page.get_by_text('linear velocity v').count())
    browser_page.get_by_role('button', name='pause').dispatch_event('click')
    run(lambda: not page.panel.playing)
    page.step(0.0)
    before = page.scenes[0].arrow('a')
    # The number beside the slider of time, which all other numbers differ from.
    shown_time = f'{page.panel.time.value:.2f}'.rstrip('0').rstrip('.')    # 5.1, not 5.10

    def fields():
        return [box for box in browser_page.locator('input:visible').all()
                if box.input_value() == shown_time]
    run(fields)
    field = fields()[0]
    field.fill('4.2')
    field.press('Enter')
    run(lambda: abs(page.time - 4.2) < 0.05)
    assert np.abs(page.scenes[0].arrow('a') - before).max() > 0.01
    browser_page.wait_for_timeout(1500)
    picture = browser_page.locator('canvas').first.screenshot()
    image = pytest.importorskip('PIL.Image')
    colours = np.array(image.open(BytesIO(picture)).convert('RGB')).reshape(-1, 3)
    assert len(np.unique(colours // 16, axis=0)) > 20       # not an empty scene


def test_what_is_found_of_the_stamps_is_told(tmp_path):
    """Here those of messages that were stamped when they arrived."""
    pytest.importorskip('rosbags')
    from support import recordings
    messages = []
    for reading, stamp, sent in islice(stampings('arrival', 500.0), 2500):
        q = np.round(MOTION.derivatives(reading, 0)[0] / 1e-5) * 1e-5
        at = recordings.START + round(stamp * 1e9)
        messages.append(('/joint_states', recordings.JOINT_STATE, at,
                         recordings.joint_state(at, ROBOT.joint_names, q)))
    bag = recordings.write_bag(tmp_path / 'run', messages)
    settings = robot_settings('puma', {'description': robot_options.PUMA})
    motion, = recorded_motions(str(bag), [settings], '')
    assert any('stamp' in doubt or 'clock' in doubt for doubt in motion.doubts), motion.doubts

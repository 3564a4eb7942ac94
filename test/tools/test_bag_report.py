# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The page about recorded motion: its numbers are the motion's, and a browser shows it."""
import re
import shutil
import subprocess

import numpy as np
import pytest

from screw_kinematics import models
from screw_kinematics.recordings.summary import EDGES
from screw_kinematics.tools.bag import main as bag, pictures
from support import recordings as rec

PUMA = str(rec.ROBOTS / 'puma560.yaml')
BROWSER = next((name for name in ('chromium', 'chromium-browser', 'google-chrome')
                if shutil.which(name)), None)


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    """Return a page about two recordings, one of which is cut off."""
    folder = tmp_path_factory.mktemp('report')
    rec.write_bag(folder / 'day' / 'whole', rec.samples(2000)) if (
        folder / 'day').mkdir() is None else None
    path = rec.write_bag(folder / 'day' / 'cut', rec.samples(3000, rate=1000.0))
    file, = path.glob('*.mcap')
    file.write_bytes(file.read_bytes()[:-3000])
    assert bag.main([str(folder / 'day'), '--robot', PUMA, '--name', 'puma', '--processes', '1',
                     '--report', str(folder / 'report.html'), '--stop-limit', '1']) == 1
    return folder / 'report.html'


def test_the_numbers_are_those_of_the_motion(page):
    text = page.read_text()
    stamps = rec.START + np.arange(2000) * 5_000_000
    state = rec.exact(stamps)
    speed = np.linalg.norm(state.classical(1)[:, 3:], axis=1)
    acceleration = np.linalg.norm(state.classical(2)[:, 3:], axis=1)
    whole = text[text.index('<summary>whole'):]
    for what, values in (('speed [m/s]', speed), ('acceleration [m/s²]', acceleration)):
        row = re.search(re.escape(what) + r'</td>' + r'<td>([\d.e+-]+)</td>' * 4, whole)
        found = np.array([float(x) for x in row.groups()])
        expected = [*np.quantile(values, [0.5, 0.95, 0.99]), values.max()]
        np.testing.assert_allclose(found, expected, rtol=0.05)
    low, high = state.pose[:, :3, 3].min(axis=0), state.pose[:, :3, 3].max(axis=0)
    assert f'x {low[0]:.3f} to {high[0]:.3f}' in whole
    slowing = -(state.classical(1)[:, 3:] * state.classical(2)[:, 3:]).sum(axis=1) / speed
    stops = (np.diff((slowing > 1).astype(int)) > 0).sum() + (slowing[0] > 1)
    assert abs(int(re.search(r'(\d+) hard stops', whole)[1]) - stops) <= 1
    assert 'cut off at byte' in text[text.index('<summary>cut'):]


def test_singularities_are_counted():
    """A straight planar arm is singular; bent at a right angle it is far from it."""
    from screw_kinematics.recordings.states import RecordedRobot, StateBlock
    from screw_kinematics.recordings.summary import Summarizer
    from screw_kinematics.pipeline.parameter_file import robot_settings
    settings = robot_settings('arm', {'description': PUMA})
    robot = RecordedRobot(settings, models.load(PUMA))
    for q5, near in ((0.0, 1.0), (np.pi / 2, 0.0)):
        summarizer = Summarizer(robot, 5.0)
        motion = np.zeros((3, 400, 6))
        motion[0, :] = (0.3, -0.6, 0.2, 0.1, q5, 0.4)
        stamps = np.arange(400) * 5_000_000
        summarizer.add(StateBlock(stamps, stamps, motion, np.zeros((400, 0)), np.zeros(400)))
        assert summarizer.summary.near_singular == pytest.approx(2.0 * near, abs=0.1)


def test_the_page_needs_nothing_else(page):
    text = page.read_text()
    assert text.startswith('<!DOCTYPE html>') and text.rstrip().endswith('</html>')
    assert not re.search(r'(src|href)=|url\(|@import|<script', text)


@pytest.mark.skipif(BROWSER is None, reason='no Chromium')
def test_a_browser_shows_it(page, tmp_path):
    command = [BROWSER, '--headless', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage',
               f'--user-data-dir={tmp_path / "profile"}']
    shown = subprocess.run([*command, '--dump-dom', page.as_uri()], capture_output=True,
                           text=True, timeout=120)
    assert shown.returncode == 0 and shown.stdout.count('<svg') >= 7
    assert '<td>speed [m/s]</td>' in shown.stdout and 'NaN' not in shown.stdout
    picture = tmp_path / 'page.png'
    subprocess.run([*command, f'--screenshot={picture}', '--window-size=900,1200',
                    page.as_uri()], capture_output=True, timeout=120, check=True)
    image = __import__('matplotlib.image', fromlist=['imread']).imread(picture)
    assert image.shape[:2] == (1200, 900)
    # Curves are drawn in their colour.
    colour = np.array([int(pictures.COLOURS[0][i:i + 2], 16) / 255 for i in (1, 3, 5)])
    assert (np.abs(image[..., :3] - colour).max(axis=2) < 0.05).sum() > 200


@pytest.mark.skipif(BROWSER is None, reason='no Chromium')
@pytest.mark.parametrize('width', [390, 1200])
def test_nothing_sticks_out_of_the_page(page, width):
    api = pytest.importorskip('playwright.sync_api')
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which(BROWSER), args=[
            '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage'], timeout=120_000)
        view = browser.new_page(viewport={'width': width, 'height': 900})
        view.goto(page.as_uri())
        view.evaluate("document.querySelectorAll('details').forEach(each => each.open = true)")
        assert view.evaluate('document.documentElement.scrollWidth') == width


def test_ticks_of_a_logarithm_are_round():
    for low, high, expected in (
            (-1.3, 0.8, [0.1, 0.2, 0.5, 1, 2, 5]), (0.05, 0.25, [1.2, 1.3, 1.4, 1.5, 1.6, 1.7]),
            (-3, 0.8, [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3])):
        text = pictures.distribution('x', 'y', np.logspace(low, high, 50), np.ones(49))
        ticks = [float(x) for x in re.findall(r'text-anchor="middle">([\d.]+)<', text)]
        np.testing.assert_allclose(ticks, expected)


def test_distributions_leave_out_what_never_was():
    seconds = np.zeros(len(EDGES) - 1)
    assert pictures.distribution('x', 'y', EDGES, seconds) == ''
    seconds[100:110] = 1.0
    assert pictures.distribution('<x>', 'y', EDGES, seconds).count('&lt;x&gt;') == 2

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Ellipsoids among the markers: the covariance that is published, in whatever axes."""
from geometry_msgs.msg import TwistWithCovarianceStamped
import numpy as np
import pytest
from screw_kinematics.node.markers import ARROWS
from screw_kinematics.screws.rotations import rotation_from_quaternion
from support.rig import joint_state, running, smooth_motion, stamp_ns
from visualization_msgs.msg import Marker, MarkerArray

PUMA = 'package://screw_kinematics/config/robots/puma560.yaml'
JOINTS = [f'q{i}' for i in range(1, 7)]
DEVIATIONS = 2.0
MARKERS = {'description': PUMA, 'outputs': ['markers'], 'markers_rate': 1000.0,
           'stale_timeout': 30.0}
ROBOTS = {
    'plain': {**MARKERS, 'outputs': ['markers', 'twist_with_covariance'],
              'markers_deviations': DEVIATIONS},
    'turned': {**MARKERS, 'markers_deviations': DEVIATIONS, 'expressed_in': 'tip',
               'reference_point': 'base'},
    'without': MARKERS}
PERIOD, START, SAMPLES = 4_000_000, 10**13, 60


@pytest.fixture(scope='module')
def got(module_context, tmp_path_factory):
    """Run a node over one motion; return markers by robot and stamp, and covariances."""
    parameters = {'robots': list(ROBOTS), **ROBOTS}
    with running(module_context, tmp_path_factory.mktemp('ellipsoids'), parameters) as rig:
        markers = {name: rig.listen(f'{name}/markers', MarkerArray) for name in ROBOTS}
        twists = rig.listen('plain/twist_with_covariance', TwistWithCovarianceStamped)
        publisher = rig.publisher('joint_states')
        for name, settings in ROBOTS.items():
            rig.wait_until_serving(name, sorted(
                settings['outputs'], key=['twist_with_covariance', 'markers'].index))
        # Programs are made in the background: send what they do not see, until all answer; at
        # rest, which tells nothing of the encoders for a new run to remember.
        warm_up, sent = 1_000_000_000, 0
        while not all(markers.values()) or not twists:
            publisher.publish(joint_state(JOINTS, warm_up, [0.2] * 6))
            rig.spin(0.004)
            sent += 1
            warm_up += PERIOD if sent % 10 else 300_000_000
        random, k = np.random.default_rng(1), 0
        while k < SAMPLES or not common(markers, twists):
            q, _ = smooth_motion(6, k * PERIOD * 1e-9)
            noisy = [x + 1e-4 * e for x, e in zip(q, random.normal(size=6))]
            publisher.publish(joint_state(JOINTS, START + k * PERIOD, noisy))
            rig.spin(0.004)
            k += 1
        yield markers, {stamp_ns(twist): twist for twist in twists}


def by_stamp(messages):
    """Return markers by name, by stamp, of the motion."""
    return {stamp_ns(message.markers[0]): {m.ns: m for m in message.markers}
            for message in messages if stamp_ns(message.markers[0]) >= START}


def common(markers, twists):
    """Return the stamps at which all is known."""
    stamps = {stamp_ns(twist) for twist in twists if any(twist.twist.covariance)}
    for name in ('plain', 'turned'):
        stamps &= {stamp for stamp, found in by_stamp(markers[name]).items()
                   if found['linear_velocity_uncertainty'].action == Marker.ADD}
    return sorted(stamps)


def spread(marker, scale):
    """Return the covariance that an ellipsoid shows."""
    o, s = marker.pose.orientation, marker.scale
    axes = rotation_from_quaternion(np.array([o.x, o.y, o.z, o.w]))
    radii = np.array([s.x, s.y, s.z]) / (2.0 * DEVIATIONS * scale)
    return axes @ np.diag(radii**2) @ axes.T


def test_ellipsoids_are_the_published_covariance(got):
    markers, twists = got
    plain, turned = by_stamp(markers['plain']), by_stamp(markers['turned'])
    stamps = common(markers, twists.values())
    assert stamps
    for stamp in stamps:
        covariance = np.reshape(twists[stamp].twist.covariance, (6, 6))
        for what, part in (('linear_velocity', slice(0, 3)), ('angular_velocity', slice(3, 6))):
            true = covariance[part, part]
            for found in plain[stamp], turned[stamp]:
                marker = found[f'{what}_uncertainty']
                assert marker.type == Marker.SPHERE and marker.color.a < 0.5
                shown = spread(marker, ARROWS[what])
                assert np.allclose(shown, true, rtol=1e-6, atol=1e-5 * true.max() + 1e-11)


def test_they_are_at_the_heads_of_the_arrows(got):
    markers, twists = got
    found = by_stamp(markers['plain'])
    for stamp in common(markers, twists.values()):
        for what in ('linear_velocity', 'angular_velocity', 'linear_acceleration'):
            arrow, ellipsoid = found[stamp][what], found[stamp][f'{what}_uncertainty']
            if arrow.action == Marker.ADD:
                head, centre = arrow.points[1], ellipsoid.pose.position
                assert np.allclose([head.x, head.y, head.z], [centre.x, centre.y, centre.z])


def test_none_are_shown_unless_asked_for(got):
    markers, _ = got
    for found in by_stamp(markers['without']).values():
        assert not any(name.endswith('uncertainty') for name in found)

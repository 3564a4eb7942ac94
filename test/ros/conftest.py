# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every ROS test has its own domain, local to this machine, here and in its processes."""
import time

import pytest

domain_coordinator = pytest.importorskip('domain_coordinator')
rclpy = pytest.importorskip('rclpy')


@pytest.fixture
def ros_domain(monkeypatch):
    """Give a free ROS_DOMAIN_ID, set in os.environ too, so that child processes have it."""
    with domain_coordinator.domain_id() as domain:
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        monkeypatch.delenv('ROS_LOCALHOST_ONLY', raising=False)
        yield domain


@pytest.fixture
def context(ros_domain):
    """Give an initialised rclpy context in the test's own domain."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    yield context
    rclpy.try_shutdown(context=context)


@pytest.fixture
def wait_until():
    """Give a function that waits for a condition and fails after a generous limit."""
    def wait(condition, timeout=60.0, poll=lambda: time.sleep(0.01), message=''):
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                pytest.fail(message or f'condition not met within {timeout} s')
            poll()
    return wait

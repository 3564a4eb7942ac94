# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every ROS test has its own domain, local to this machine, here and in its processes."""
from contextlib import contextmanager
import gc
import os
import socket
import time

import pytest

if os.environ.get('SCREW_KINEMATICS_ROS_REQUIRED'):     # where ROS is known to be: CI
    import domain_coordinator
    import rclpy
else:
    domain_coordinator = pytest.importorskip('domain_coordinator')
    rclpy = pytest.importorskip('rclpy')


def occupied(domain):
    """Return whether somebody is in a domain, as a node that was left by a run that was killed."""
    for participant in range(20):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
            try:
                port.bind(('', 7410 + 250 * domain + 2 * participant))
            except OSError:
                return True
    return False


def unoccupied():
    """Yield domains that nobody is in."""
    yield from (domain for domain in range(1, 101) if not occupied(domain))
    pytest.fail('somebody is in each of the 100 domains of ROS')


@contextmanager
def own_domain():
    """Give a free ROS_DOMAIN_ID, set in os.environ too, so that child processes have it."""
    free = unoccupied()
    with domain_coordinator.domain_id(lambda: next(free)) as domain, \
            pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_DOMAIN_ID', str(domain))
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        patch.delenv('ROS_LOCALHOST_ONLY', raising=False)
        yield domain


@contextmanager
def initialised_context(domain):
    """Give an initialised rclpy context in a domain."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    yield context
    # A node whose making failed lives on in reference cycles, visible to the next test.
    gc.collect()
    rclpy.try_shutdown(context=context)
    gc.collect()


@pytest.fixture
def ros_domain():
    """Give the test its own domain."""
    with own_domain() as domain:
        yield domain


@pytest.fixture
def context(ros_domain):
    """Give an initialised rclpy context in the test's own domain."""
    with initialised_context(ros_domain) as context:
        yield context


@pytest.fixture(scope='module')
def module_context():
    """Give an initialised rclpy context in a domain of the module's tests."""
    with own_domain() as domain, initialised_context(domain) as context:
        yield context


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

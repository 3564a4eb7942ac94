# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Every ROS test has its own domain, local to this machine, here and in its processes."""
from contextlib import contextmanager
import gc
import os
import time

import pytest

if not os.environ.get('SCREW_KINEMATICS_ROS_REQUIRED'):     # where ROS is known to be: CI
    pytest.importorskip('domain_coordinator')
    pytest.importorskip('rclpy')
import rclpy    # noqa: E402, I100, I202
from benchmark.domain import own_domain     # noqa: E402, I100


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

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A ROS domain of one's own, for benchmarks and for tests."""
from collections.abc import Iterator
from contextlib import contextmanager
import os
import socket

import domain_coordinator

VARIABLES = 'ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_LOCALHOST_ONLY'
"""What ROS finds its domain by."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Give a domain of this machine that nobody is in, in os.environ too, for child processes."""
    free = unoccupied()
    with domain_coordinator.domain_id(lambda: next(free)) as domain:
        before = {name: os.environ.pop(name, None) for name in VARIABLES}
        os.environ.update(ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
        try:
            yield domain
        finally:
            for name, value in before.items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value


def unoccupied() -> Iterator[int]:
    """Yield domains that nobody is in."""
    yield from (domain for domain in range(1, 101) if not occupied(domain))
    raise RuntimeError('somebody is in each of the 100 domains of ROS')


def occupied(domain: int) -> bool:
    """Return whether somebody is in a domain, as a node that was left by a run that was killed."""
    for participant in range(20):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
            try:
                port.bind(('', 7410 + 250 * domain + 2 * participant))
            except OSError:
                return True
    return False

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Run the examples in the docstrings of every module of the library."""
import doctest
import importlib
import pkgutil

import pytest

import screw_kinematics

MODULES = ['screw_kinematics'] + [
    m.name for m in pkgutil.walk_packages(screw_kinematics.__path__, 'screw_kinematics.')
    if '.node' not in m.name]


@pytest.mark.parametrize('name', MODULES)
def test_examples(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0

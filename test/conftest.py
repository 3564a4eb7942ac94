# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Texts are compiled once, and long files come first, so that workers end together."""
import gc
import os
import sys

import pytest

# The tests start some hundred processes; else each of them would compile the package anew.
os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
sys.dont_write_bytecode = False
# The workers have all cores already: more threads would wait for each other, and burn time so.
os.environ.update(OPENBLAS_NUM_THREADS='1', OMP_NUM_THREADS='1', MKL_NUM_THREADS='1')

LONG = ('test_packaging_installs.py', 'test_soak.py', 'test_oldest_cython.py', 'test_mypy.py',
        'test_node_told.py', 'test_demo.py', 'test_long_compilations.py', 'test_check.py',
        'test_live_clocks.py', 'test_live_imu.py', 'test_device_clock.py', 'test_derive.py',
        'test_arena.py', 'test_clock_offset.py', 'test_flake8.py', 'test_fleet.py',
        'test_identify.py', 'test_view_live.py', 'test_parallel.py', 'test_stated_deviations.py',
        'test_hostile.py', 'test_node_input.py', 'test_full_disk.py', 'test_program.py',
        'test_view.py', 'test_no_python_in_loops.py', 'test_plot.py', 'test_node_three_robots.py',
        'test_hostile_requests.py', 'test_main.py', 'test_bag.py', 'test_pep257.py',
        'test_posture_tracker.py', 'test_docs.py')


def pytest_configure(config):
    """Have pytest-xdist hand out files in their order, not those with many tests first."""
    if hasattr(config.option, 'loadscopereorder'):
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items):
    """Order the files."""
    items.sort(key=lambda item: LONG.index(item.path.name) if item.path.name in LONG
               else len(LONG))


@pytest.hookimpl(hookwrapper=True)
def pytest_collection():
    """Let the garbage collector pass over what stays to the end: a quarter of the time else."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()

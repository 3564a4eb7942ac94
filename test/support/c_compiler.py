# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The C compiler of this machine, if it has one."""
import shutil

import pytest

COMPILER = shutil.which('cc') or shutil.which('gcc') or shutil.which('clang')
needs_compiler = pytest.mark.skipif(COMPILER is None, reason='no C compiler on the path')

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools by name: ``python -m screw_kinematics TOOL``."""
from .tools.main import main

if __name__ == '__main__':
    raise SystemExit(main())

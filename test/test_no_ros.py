# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The library works without ROS: no module but those that run or are nodes needs it."""
import subprocess
import sys

LIBRARY_WITHOUT_ROS = """
import importlib, pkgutil, sys

class NoRos:
    def find_spec(self, name, path=None, target=None):
        top = name.partition('.')[0]
        if top in ('rclpy', 'ament_index_python') or top.endswith(('_msgs', '_interfaces')):
            raise ModuleNotFoundError(f'{name} is blocked', name=name)

sys.meta_path.insert(0, NoRos())
import screw_kinematics
names = [m.name for m in pkgutil.walk_packages(screw_kinematics.__path__, 'screw_kinematics.')]
names = [n for n in names if '.node' not in n]
for name in names:
    importlib.import_module(name)
assert 'rclpy' not in sys.modules
print(len(names))
"""


def test_every_library_module_imports_with_ros_blocked():
    run = subprocess.run([sys.executable, '-c', LIBRARY_WITHOUT_ROS],
                         capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert int(run.stdout) >= 6

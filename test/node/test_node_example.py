# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""The example parameters run as they are, and the policy lists what the node then uses."""
from pathlib import Path
import xml.etree.ElementTree as ElementTree

from screw_kinematics.pipeline.settings import NODE as NODE_SETTINGS, ROBOT as ROBOT_SETTINGS
from support.rig import NODE, running
import yaml

CONFIG = Path(__file__).parents[2] / 'config'
EXAMPLE = CONFIG / 'kinematic_states.yaml'


def policy(kind, right):
    """Return the names of the policy, such as topics to publish."""
    tree = ElementTree.parse(CONFIG / 'enclave_policy.xml')
    return {item.text for group in tree.iter(f'{kind}s') if group.get(right) == 'ALLOW'
            for item in group}


def test_example_runs_and_the_policy_is_exact(context, tmp_path):
    with running(context, tmp_path, {}, ['--params-file', str(EXAMPLE)]) as rig:
        rig.wait(lambda: rig.status('panda')[0] is not None)
        assert rig.status('node')[1] == 'active', rig.status('node')
        of_node = (NODE, '/')
        for kind, right, names in (
                ('topic', 'publish', rig.node.get_publisher_names_and_types_by_node),
                ('topic', 'subscribe', rig.node.get_subscriber_names_and_types_by_node),
                ('service', 'reply', rig.node.get_service_names_and_types_by_node)):
            expected = policy(kind, right)
            rig.wait(lambda: {name for name, _ in names(*of_node)} >= expected)
            assert {name for name, _ in names(*of_node)} == expected


def test_example_writes_out_every_default():
    given = yaml.safe_load(EXAMPLE.read_text())['/**']['ros__parameters']
    flat = {f'{group}.{key}': value for group in ('estimator', 'payload')
            for key, value in given['puma'].pop(group).items()}
    flat |= given['puma']
    assert set(flat) == {setting.name for setting in ROBOT_SETTINGS}
    for setting in ROBOT_SETTINGS:
        if setting.name != 'description':
            assert flat[setting.name] == setting.default, setting.name
    for setting in NODE_SETTINGS:
        assert setting.name == 'robots' or given[setting.name] == setting.default

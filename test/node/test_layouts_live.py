# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""What the layouts of Foxglove, PlotJuggler and RViz show is there when the demo's robot moves."""
import json
import math
from pathlib import Path
import re
from xml.etree import ElementTree

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from screw_kinematics import models
from screw_kinematics.node.publishers import message_type
from screw_kinematics.pipeline.outputs import KINDS
from support.rig import joint_state, PUMA, running, smooth_motion
import yaml

ROOT = Path(__file__).parents[2]
START, PERIOD = 10**11, 5_000_000


def demo_outputs():
    """Return the outputs that the demo's launch file asks for."""
    text = (ROOT / 'launch' / 'demo.launch.py').read_text()
    return re.search(r"'outputs': '([\w,]+)'", text)[1].split(',')


def shown():
    """Return topics and the fields of them that the layouts show, by topic."""
    layout = json.loads((ROOT / 'config' / 'foxglove_layout.json').read_text())
    fields = {}
    for panel in layout['configById'].values():
        for path in panel.get('paths', ()):
            topic, *names = path['value'].split('.')
            fields.setdefault(topic, set()).add(tuple(names))
        for topic in [*panel.get('topics', ()), *filter(None, [panel.get('topicToRender')])]:
            fields.setdefault(topic, set())
    root = ElementTree.parse(ROOT / 'config' / 'plotjuggler_layout.xml').getroot()
    for curve in root.iter('curve'):
        _, robot, output, *names = curve.get('name').split('/')
        fields.setdefault(f'/{robot}/{output}', set()).add(tuple(names))
    rviz = yaml.safe_load((ROOT / 'config' / 'kinematic_states.rviz').read_text())
    for display in rviz['Visualization Manager']['Displays']:
        if 'Topic' in display:      # remapped to that of the robot by the launch file
            fields.setdefault(f'/robot/{display["Topic"]["Value"]}', set())
    return fields


def test_every_topic_and_field_of_the_layouts_comes(context, tmp_path):
    model, outputs = models.load(PUMA), demo_outputs()
    of_robot = {topic: names for topic, names in shown().items() if topic.startswith('/robot/')}
    assert {f'/robot/{output}' for output in outputs} == set(of_robot)
    assert set(shown()) - set(of_robot) <= {'/diagnostics', '/robot_description'}
    with running(context, tmp_path, {
            'robots': ['robot'], 'robot': {'description': PUMA, 'outputs': outputs}}) as rig:
        found = {topic: rig.listen(topic, message_type(KINDS[topic.split('/')[2]].type_name))
                 for topic in of_robot}
        rig.wait_until_serving('robot', [name for name in KINDS if name in outputs])
        states = rig.publisher('joint_states')
        k = 0
        while not all(found.values()):
            q, qd = smooth_motion(6, k * PERIOD * 1e-9)
            states.publish(joint_state(model.joint_names, START + k * PERIOD, q, qd))
            rig.spin(0.005)
            k += 1
            assert k < 20000, {topic: len(messages) for topic, messages in found.items()}
        for topic, names in of_robot.items():
            for path in names:
                value = found[topic][-1]
                for name in path:
                    value = getattr(value, name)
                assert isinstance(value, float) and math.isfinite(value), (topic, path)
        namespaces = {m.ns for m in found['/robot/markers'][-1].markers}
        assert {'linear_velocity', 'linear_acceleration', 'screw_axis'} <= namespaces
        # The frame in which RViz looks at them is that of the messages.
        rviz = yaml.safe_load((ROOT / 'config' / 'kinematic_states.rviz').read_text())
        fixed = rviz['Visualization Manager']['Global Options']['Fixed Frame']
        assert fixed == found['/robot/twist'][-1].header.frame_id
        assert isinstance(rig.received['/diagnostics'][-1], DiagnosticArray)
        assert np.isfinite(found['/robot/pose'][-1].pose.position.x)

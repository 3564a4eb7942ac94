# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Layouts for RViz, Foxglove and PlotJuggler show topics and fields that there are."""
import json
from pathlib import Path
import re
from xml.etree import ElementTree

import pytest

import screw_kinematics.pipeline.outputs as outputs
import yaml

CONFIG = Path(__file__).parents[1] / 'config'


def check(topic, *path):
    """Check that a field of a topic of the node exists, and is a number."""
    typesys = pytest.importorskip('rosbags.typesys')
    types = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    robot, output = topic.strip('/').split('/')
    assert robot == 'robot'
    kind = outputs.KINDS[output].type_name
    for name in path:
        fields = {field: description for field, description in types.get_msgdef(kind).fields}
        assert name in fields, f'{topic}: {kind} has no {name}'
        kind = fields[name][1]
    return kind


def test_foxglove_plots_are_of_fields_of_the_node():
    layout = json.loads((CONFIG / 'foxglove_layout.json').read_text())
    panels = layout['configById']
    values = [path['value'] for panel in panels.values() for path in panel.get('paths', ())]
    assert len(values) == 12
    for value in values:
        topic, *path = value.split('.')
        assert check(topic, *path)[0] == 'float64'
    for topic in panels['3D!robot']['topics']:
        check(topic)
    placed = re.findall(r'"([A-Za-z0-9]+![a-z_]+)"', json.dumps(layout['layout']))
    assert set(placed) == set(panels)


def test_plotjuggler_curves_are_of_fields_of_the_node():
    root = ElementTree.parse(CONFIG / 'plotjuggler_layout.xml').getroot()
    curves = [curve.get('name') for curve in root.iter('curve')]
    assert len(curves) == 12
    subscribed = {topic.get('name') for topic in root.iter('topic')}
    for curve in curves:
        _, robot, output, *path = curve.split('/')
        assert check(f'/{robot}/{output}', *path)[0] == 'float64'
        assert f'/{robot}/{output}' in subscribed


def test_rviz_shows_the_markers():
    displays = yaml.safe_load((CONFIG / 'kinematic_states.rviz').read_text())[
        'Visualization Manager']['Displays']
    topics = {d['Topic']['Value'] for d in displays if d['Class'].endswith('MarkerArray')}
    assert topics == {'markers'} and 'markers' in outputs.KINDS

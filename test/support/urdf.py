# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Small descriptions of robots."""


def joint(name, parent, child, kind='revolute', parts='<axis xyz="0 0 1"/>'):
    return (f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="{child}"/>{parts}</joint>')


def robot(links, *joints):
    return '<robot name="r">' + ''.join(
        f'<link name="{link}"/>' for link in links.split()) + ''.join(joints) + '</robot>'

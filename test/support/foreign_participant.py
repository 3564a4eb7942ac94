# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A participant without ROS, which can put any bytes where nodes expect their messages."""
from dataclasses import dataclass
import os

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, uint8
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic


ON_THIS_MACHINE = (
    '<General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
    '<AllowMulticast>false</AllowMulticast></General>'
    '<Discovery><ParticipantIndex>auto</ParticipantIndex>'
    '<MaxAutoParticipantIndex>100</MaxAutoParticipantIndex>'
    '<Peers><Peer address="127.0.0.1"/></Peers></Discovery>')


class ForeignParticipant:
    """Joins the tests' domain."""

    def __enter__(self):
        os.environ['CYCLONEDDS_URI'] = ON_THIS_MACHINE
        self._participant = DomainParticipant(int(os.environ['ROS_DOMAIN_ID']))
        return self

    def __exit__(self, *_):
        self._participant = None

    def writer(self, topic, kind):
        """Return a writer for a DDS topic whose type has the name of a ROS type."""
        return ForeignWriter(self._participant, topic, kind)


class ForeignWriter:
    """Writes bytes to a topic, under the type's name and whatever they are."""

    def __init__(self, participant, topic, kind):
        package, folder, _ = kind.__module__.split('.')
        self._participant, self._topic = participant, topic
        self._type_name = f'{package}::{folder}::dds_::{kind.__name__}_'
        self._writers = {}
        self.of_size(0)

    def of_size(self, size):
        """Return the writer for so many bytes, since the type has a size."""
        if size not in self._writers:
            @dataclass
            class Bytes(IdlStruct, typename=self._type_name):
                content: array[uint8, max(size, 1)]

            qos = Qos(Policy.Reliability.Reliable(1_000_000_000), Policy.History.KeepLast(100))
            writer = DataWriter(
                self._participant, Topic(self._participant, self._topic, Bytes, qos=qos), qos=qos)
            self._writers[size] = writer, Bytes
        return self._writers[size]

    def matched(self):
        """Return whether a reader has been found."""
        return len(self.of_size(0)[0].get_matched_subscriptions()) > 0

    def write(self, content):
        """Write these bytes, and at least one."""
        writer, kind = self.of_size(len(content))
        writer.write(kind(list(content or bytes(1))))

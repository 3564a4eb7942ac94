# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""URDF: bytes in which encodings are read, and which are refused."""
import pytest

from screw_kinematics import models
from screw_kinematics.errors import ModelError
from support.urdf import joint, robot

TWO = robot('a b c', joint('j', 'a', 'b'), joint('k', 'b', 'c', 'prismatic'))


def test_declared_encodings_are_heeded():
    for name, codec in (('ISO-8859-1', 'latin-1'), ('cp1252', 'cp1252'), ('utf8', 'utf-8')):
        text = f'<?xml version="1.0" encoding="{name}"?>' + robot('a b', joint('Öl', 'a', 'b'))
        assert models.load_urdf(text.encode(codec)).joint_names == ('Öl',)


@pytest.mark.parametrize('codec', ['utf-8-sig', 'utf-16', 'utf-32', 'utf-16-le', 'utf-16-be'])
def test_byte_order_marks_are_heeded(codec):
    text = '<?xml version="1.0"?>' + robot('a b', joint('Öl', 'a', 'b'))
    assert models.load_urdf(text.encode(codec)).joint_names == ('Öl',)


@pytest.mark.parametrize('encoding', ['gbk', 'shift_jis', 'UTF-16', 'utf-32', 'euc_kr', 'cp037'])
def test_plain_ascii_is_read_whatever_encoding_it_declares(encoding):
    text = f'<?xml version="1.0" encoding="{encoding}"?>' + TWO
    assert models.load_urdf(text.encode()).dof == 2


@pytest.mark.parametrize('encoding', [
    'foo', 'hex', 'rot13', 'base64', 'zlib', 'bz2', 'uu', 'quopri', 'idna', 'punycode',
    'undefined', 'unicode_escape', 'utf-8\0x', 'x' * 300])
def test_encodings_that_are_none_of_text_are_refused(encoding):
    text = f'<?xml version="1.0" encoding="{encoding}"?>' + TWO
    with pytest.raises(ModelError, match='arm.urdf: encoding: got .*; allowed: one of text') as e:
        models.load_urdf(text.encode(), source='arm.urdf')
    assert len(str(e.value)) < 300
    if '\0' not in encoding:
        assert models.load_urdf(text).dof == 2      # text from a topic is decoded already


def test_bytes_that_do_not_follow_their_encoding_are_refused():
    text = '<?xml version="1.0" encoding="utf-8"?>' + robot('a b', joint('Öl', 'a', 'b'))
    with pytest.raises(ModelError, match="robot_description: not utf-8: .*invalid"):
        models.load_urdf(text.encode('latin-1'))


@pytest.mark.parametrize('before', ['', '\n  ', '\ufeff', '\ufeff\n', '\n\ufeff\r\n '])
def test_declarations_may_come_after_blanks(before):
    text = before + '<?xml version="1.0"?>' + TWO
    assert models.load_urdf(text).dof == models.load_urdf(text.encode()).dof == 2
    with pytest.raises(ModelError, match=f'line {1 + before.count(chr(10))}'):
        models.load_urdf(text + '<')

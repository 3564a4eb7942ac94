# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Pictures for a page, as SVG text: curves over time, distributions, paths seen from two sides.

Written by hand: the extra ``bag`` has no matplotlib, which would take half a minute for the
pictures of some hundred recordings.
"""
from __future__ import annotations

from collections.abc import Sequence
from html import escape
import math

import numpy as np

from ...screws.se3 import Array

COLOURS = ('#1f5fa8', '#c2491d')
_WIDTH, _HEIGHT = 460, 200
_LEFT, _RIGHT, _TOP, _BOTTOM = 54, 12, 22, 34


def curves(title: str, across: str, x: Array, series: Sequence[tuple[str, Array]]) -> str:
    """Return at most two curves above each other, each with its own scale from 0 and label."""
    parts = []
    for i, (label, values) in enumerate(series):
        top = _TOP + i * _HEIGHT
        scale = _Scale(float(x.min()), float(x.max()), 0.0, float(values.max()), top)
        parts += [scale.frame(across if i + 1 == len(series) else '', label),
                  scale.line(x, values, COLOURS[i])]
    return _picture(title, _HEIGHT * len(series) + _BOTTOM, parts)


def distribution(title: str, across: str, edges: Array, seconds: Array) -> str:
    """
    Return for how much of the time a quantity was at least a value, over its logarithm.

    The time is given by classes, ``seconds[k]`` between ``edges[k]`` and ``edges[k + 1]``.
    """
    there = np.flatnonzero(seconds)
    if not len(there):
        return ''
    inside = slice(max(int(there[0]) - 1, 0), int(there[-1]) + 2)
    above = 100 * np.cumsum(seconds[::-1])[::-1] / seconds.sum()
    x = np.log10(edges[:-1][inside])
    scale = _Scale(float(x[0]), float(x[-1]), 0.0, 100.0, _TOP)
    parts = [scale.frame(across, '% of the time at least', logarithmic=True),
             scale.line(x, above[inside], COLOURS[0])]
    return _picture(title, _HEIGHT + _BOTTOM, parts)


def path_views(title: str, points: Array) -> str:
    """Return a path, of shape (N, 3) [m], from above and from the side, in the same scale."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = max(float(np.ptp(points, axis=0).max()) / 2, 1e-3) * 1.05
    size = (_WIDTH - 2 * _LEFT) // 2
    parts = []
    for i, (across, up) in enumerate(((0, 1), (0, 2))):
        scale = _Scale(middle[across] - half, middle[across] + half, middle[up] - half,
                       middle[up] + half, _TOP, _LEFT + i * (size + _LEFT), size, size)
        parts += [scale.frame(f'{"xyz"[across]} [m]', f'{"xyz"[up]} [m]'),
                  scale.line(points[:, across], points[:, up], COLOURS[0])]
    return _picture(title, _TOP + size + _BOTTOM, parts)


class _Scale:
    """From values to a place in a picture, with its frame and ticks."""

    def __init__(self, left: float, right: float, low: float, high: float, top: float,
                 at: float = _LEFT, width: float = _WIDTH - _LEFT - _RIGHT,
                 height: float = _HEIGHT - _BOTTOM) -> None:
        self.left, self.right = left, right if right > left else left + 1.0
        self.low, self.high = low, high if high > low else low + 1.0
        self.at, self.top, self.width, self.height = at, top, width, height

    def x(self, value: Array | float) -> Array | float:
        return self.at + (value - self.left) / (self.right - self.left) * self.width

    def y(self, value: Array | float) -> Array | float:
        return self.top + self.height - (
            value - self.low) / (self.high - self.low) * self.height

    def line(self, x: Array, y: Array, colour: str) -> str:
        points = ' '.join(f'{a:.1f},{b:.1f}' for a, b in zip(self.x(x), self.y(y)))  # type: ignore
        return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.2"/>'

    def frame(self, across: str, up: str, logarithmic: bool = False) -> str:
        bottom = self.top + self.height
        parts = [f'<rect x="{self.at}" y="{self.top}" width="{self.width}" '
                 f'height="{self.height}" fill="none" stroke="#999"/>']
        for value in (_ticks_of_decades if logarithmic else _ticks)(self.left, self.right):
            text = f'{10**value:g}' if logarithmic else f'{value:g}'
            parts.append(_text(float(self.x(value)), bottom + 13, text, 'middle'))
        for value in _ticks(self.low, self.high):
            parts.append(_text(self.at - 4, float(self.y(value)) + 4, f'{value:g}', 'end'))
        parts.append(_text(self.at + self.width, bottom + 27, across, 'end'))
        parts.append(_text(self.at, self.top - 6, up, 'start'))
        return ''.join(parts)


def _ticks(low: float, high: float) -> list[float]:
    """Return four to nine round values in a range."""
    step = 10 ** math.floor(math.log10((high - low) / 4))
    step *= 5 if (high - low) / step > 20 else 2 if (high - low) / step > 9 else 1
    first = math.ceil(low / step - 1e-9)
    return [round(k * step, 12) for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _ticks_of_decades(low: float, high: float) -> list[float]:
    """Return the logarithms of some round values in a range of logarithms."""
    if high - low < 0.6:
        return [math.log10(value) for value in _ticks(10**low, 10**high)]
    steps = (1, 2, 5) if high - low < 3 else (1, 3) if high - low < 4.5 else (1,)
    found = [decade + math.log10(step) for decade in range(math.floor(low), math.ceil(high) + 1)
             for step in steps]
    return [value for value in found if low <= value <= high]


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _picture(title: str, height: float, parts: Sequence[str]) -> str:
    return (f'<figure><svg viewBox="0 0 {_WIDTH} {height:.0f}" role="img" '
            f'aria-label="{escape(title)}">{"".join(parts)}</svg>'
            f'<figcaption>{escape(title)}</figcaption></figure>')

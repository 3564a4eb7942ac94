# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture of two clocks: what was correlated, and the two signals."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..plot.histories import pyplot
from ...recordings.clock_offset import (
    Channels, ClockOffset, predicted, SEARCH, shares_explained)
from ...recordings.link_motion import LinkMotion
from ...recordings.motion_streams import Stream
from ...screws.se3 import Array

_SHOWN = 1.0        # of the signals [s]
_NARROW = 5e-3      # offsets beside the one found that are drawn densely [s]


def draw_offset(path: Path, topic: str, stream: Stream, groups: Sequence[Channels],
                measured: Sequence[str], link: LinkMotion, found: ClockOffset) -> None:
    """Draw the share of the motion by offset, and the signals where they move most."""
    plt = pyplot()
    plt.switch_backend('agg')       # into a file, wherever this runs
    figure, (above, below) = plt.subplots(2, 1, figsize=(8, 6), layout='constrained')
    offsets = np.unique(np.concatenate([
        np.linspace(-SEARCH, SEARCH, 101), found.offset + np.linspace(-_NARROW, _NARROW, 11)]))
    for what, group in zip(measured, groups):
        above.plot(1e3 * offsets, 100 * shares_explained(
            link.stamps, stream.stamps, group, offsets), label=what)
    low, high = found.interval
    above.axvspan(1e3 * low, 1e3 * high, color='0.8')
    above.axvline(1e3 * found.offset, color='0.4', linewidth=0.8)
    above.set(xlabel='offset [ms]', ylabel='explained by the joints [%]',
              title=f'{topic}: offset {1e3 * found.offset:+.3f} ms, 95 % between '
                    f'{1e3 * low:+.3f} and {1e3 * high:+.3f} ms')
    above.legend()
    # What never changes is explained wholly, and tells nothing.
    best = int(np.argmax([share * bool(np.ptp(group.values))
                          for share, group in zip(found.shares, groups)]))
    _draw_signals(below, stream, groups[best], found.coefficients[best], link, found,
                  measured[best])
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_signals(axes: Any, stream: Stream, group: Channels, coefficients: Array,
                  link: LinkMotion, found: ClockOffset, what: str) -> None:
    """Draw the channel that moves most, as measured and as the joints say."""
    margin = round(1e9 * (abs(found.offset) + 0.02))
    inside = (stream.stamps > link.stamps[0] + margin) & (stream.stamps < link.stamps[-1] - margin)
    at, values = stream.stamps[inside], group.values[inside]
    shown = predicted(link.stamps, at, group, coefficients, found.offset)
    channel = int(np.argmax(shown.std(axis=0) / np.maximum((values - shown).std(axis=0), 1e-30)))
    slope = np.abs(np.gradient(shown[:, channel]))
    time = (at - at[0]) * 1e-9
    middle = float(time[int(np.argmax(np.convolve(slope, np.ones(5), 'same')))])
    begin = min(max(middle - _SHOWN / 2, 0.0), max(float(time[-1]) - _SHOWN, 0.0))
    part = (time >= begin) & (time <= begin + _SHOWN)
    apart = predicted(link.stamps, at[part], group, coefficients, 0.0)[:, channel]
    axes.plot(time[part], values[part, channel], '.', markersize=3,
              label='measured')
    axes.plot(time[part], shown[part, channel], label='joints, '
              f'{1e3 * found.offset:+.2f} ms')
    axes.plot(time[part], apart, '--', linewidth=0.8,
              label='joints, as stamped')
    axes.set(xlabel='time [s]', ylabel=f'{what}, {"xyz"[channel % 3]}')
    axes.legend()

# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Tables of the comparison on simulated recordings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from rich.table import Table


def overview(summaries: dict[str, dict], add: float) -> Table:
    """Return the summary as a table."""
    shown = Table(title='RMS error at the claimed stamp, relative to usual practice '
                        '(geometric mean over moving cells)')
    for heading in ('estimator', 'acceleration', 'worst cell', 'velocity', 'standstill rad/s²',
                    'overshoot', 'settling ms', 'delay ms', 'cost us', 'cost / np.add'):
        shown.add_column(heading, justify='left' if heading == 'estimator' else 'right')
    for name, s in summaries.items():
        shown.add_row(
            name, f"{s['relative']:.3f}", f"{s['worst']:.2f}", f"{s['velocity']:.3f}",
            f"{s['standstill']:.4f}", f"{s['overshoot']:.2f}", f"{1e3 * s['settling']:.0f}",
            f"{1e3 * s['delay']:.0f}", f"{s['cost']:.0f}", f"{s['cost'] / add:.0f}")
    return shown


def by_condition(summaries: dict[str, dict], conditions: Sequence[str]) -> Iterator[Table]:
    """Yield tables with a row for each condition: errors, and prices of what is wrong."""
    for key, title in (('conditions', 'acceleration error relative to usual practice'),
                       ('prices', 'acceleration error over that without what is wrong')):
        names = [name for name, s in summaries.items() if s[key]]
        if not names:
            continue
        shown = Table(title=f'{title}, by condition')
        shown.add_column('condition')
        for name in names:
            shown.add_column(name, justify='right')
        for condition in conditions:
            shown.add_row(condition, *(f'{summaries[name][key].get(condition, np.nan):.3g}'
                                       for name in names))
        yield shown

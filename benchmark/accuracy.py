# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""
Print how far floating point is from exact arithmetic on extreme motions.

Run from the root of the source tree: ``python -m benchmark.accuracy``.
"""
from pathlib import Path
import sys

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))

# Exact differentiation and the cases live with the tests, which hold them to bounds.
from support.accuracy_cases import cases, errors, inverse_errors, QUANTITIES    # noqa: E402

WIDTH = 43


def main() -> None:
    """Print one row for each extreme motion, and one for each distance to a singularity."""
    rows = [(case.name, errors(case)) for case in cases()]
    for method in ('library', 'compiled'):
        print(f'{"largest error / largest entry, " + method:{WIDTH}}'
              + ''.join(f'{name:>15}' for name in QUANTITIES))
        for name, found in rows:
            print(f'{name:{WIDTH}}' + ''.join(f'{found[method][q]:15.1e}' for q in QUANTITIES))
        print()
    print(f'{"joint rates from a twist":{WIDTH}}{"condition":>15}{"error":>15}')
    for distance, condition, error in inverse_errors():
        print(f'{f"wrist {distance:g} rad from singular":{WIDTH}}{condition:15.1e}{error:15.1e}')


if __name__ == '__main__':
    main()

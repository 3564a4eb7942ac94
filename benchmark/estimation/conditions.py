# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""How joints are measured: rate, resolution, stamps, velocity field, what goes wrong."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any


def _unseeded(default: Any) -> Any:
    """Return a field that leaves the noise as it is: a fault and its twin share it."""
    return field(default=default, repr=False)


@dataclass(frozen=True)
class Condition:
    """
    One way of measuring.

    A measured velocity has a standard deviation [rad/s]; or is 'zero' (filled with zeros),
    'differenced' (from the positions), 'filtered' (that, low-passed at 30 Hz), 'low-passed' (the
    true one at 30 Hz), 'coherent' (with slow noise), 'scaled' (2 % too large); None: absent.
    Samples of a burst arrive, and are stamped, together: 20 us apart, when the last is taken. With
    a driver's way of stamping, of `screw_kinematics.tools.stamping`, there is neither stamp_error
    nor jitter. Odd positions, twenty for each joint, are off by the glitch, or 'repeated'.
    """

    rate: float                            # Hz
    resolution: float = 1e-5               # of the encoder, rad
    stamp_error: float = 20e-6             # standard deviation of the stamp, s
    velocity: float | str | None = None
    lag: float = 0.0                       # of the velocity, s
    faults: bool = False                   # 3 % of messages dropped, 1 % doubled, 1 % swapped
    jitter: float = 0.1                    # share of the period; the stamp knows it
    burst: int = _unseeded(1)
    stamps: str = _unseeded('')
    dither: float = _unseeded(0.3)         # noise before rounding, in steps of the encoder
    amplitude: float = _unseeded(1.0)      # share of the motion's
    glitch: float | str = _unseeded(0.0)   # rad
    together: int = _unseeded(1)           # odd positions in a row
    speed_noise: float = _unseeded(0.0)    # white noise of the position, s times the speed
    ripple: tuple[tuple[float, float], ...] = _unseeded(())    # (per turn, rad), by the angle

    def twin(self) -> Condition:
        """Return the condition without what goes wrong with stamps and positions."""
        return replace(self, burst=1, stamps='', dither=0.3, glitch=0.0, together=1,
                       speed_noise=0.0, ripple=())


CONDITIONS = {
    '100 Hz': Condition(100),
    '100 Hz, velocity': Condition(100, 1e-4, velocity=5e-3),
    '250 Hz, network': Condition(250, stamp_error=100e-6, faults=True),
    '500 Hz, velocity': Condition(500, velocity=5e-3),
    '500 Hz, coarse': Condition(500, 1e-4),
    '1 kHz': Condition(1000, 1e-6),
    '1 kHz, velocity': Condition(1000, 1e-4, velocity=5e-3),
    '1 kHz, simulator': Condition(1000, 0.0, 0.0, 1e-9),
    '250 Hz, late velocity': Condition(250, 1e-6, velocity=1e-3, lag=5e-3, faults=True),
    '500 Hz, zero velocity': Condition(500, velocity='zero'),
    '100 Hz, hobby servo': Condition(100, 1.5e-3, 200e-6),
    '500 Hz, differenced velocity': Condition(500, 1e-4, velocity='differenced'),
    '500 Hz, filtered velocity': Condition(500, 1e-4, velocity='filtered'),
    '250 Hz, stamped on arrival': Condition(250, 1e-6, 200e-6, faults=True, jitter=0.0),
    '500 Hz, bursts of five': Condition(500, 1e-5, 50e-6, jitter=0.0, burst=5),
}
"""Drivers that stamp their readings, more or less."""

STAMPING = {
    f'{way} {rate:g} Hz': Condition(rate, stamp_error=0.0, jitter=0.0, stamps=way)
    for way, rate in (
        ('arrival', 1000), ('arrival', 500), ('arrival', 100), ('reader', 1000), ('reader', 93),
        ('held', 1000), ('held', 500), ('lost', 1000), ('lost', 500), ('stalls', 500),
        ('clock_set', 500), ('bursts', 500), ('rounded', 250), ('made_up', 200))
}
"""Ways of stamping that tell little of when a joint was read."""


def _clear(rate: float, resolution: float = 1e-5, **what: Any) -> Condition:
    """Return a condition with stamps that are right."""
    return Condition(rate, resolution, stamp_error=1e-6, jitter=0.02, **what)


MEASURING = {
    **{f'staircase {rate:g} Hz {step:g} x{amplitude:g}': _clear(
        rate, step, dither=0.0, amplitude=amplitude)
       for rate, step, amplitude in ((1000, 1e-6, 0.01), (1000, 1e-4, 1.0), (1000, 1e-4, 0.1),
                                     (500, 3.8e-4, 0.1), (250, 1e-4, 0.1), (100, 1.5e-3, 1.0))},
    'lone 15 mrad 1 kHz': _clear(1000, glitch=0.015),
    'lone 0.1 mrad 1 kHz': _clear(1000, glitch=1e-4),
    'three 15 mrad 1 kHz': _clear(1000, glitch=0.015, together=3),
    'lone 15 mrad 100 Hz': _clear(100, glitch=0.015),
    'repeated 1 kHz': _clear(1000, glitch='repeated'),
    'repeated 100 Hz': _clear(100, glitch='repeated'),
    'noise with speed 1 kHz': _clear(1000, speed_noise=1e-4),
    'noise with speed 250 Hz': _clear(250, speed_noise=1e-4),
    'gears 1 kHz': _clear(1000, ripple=((51, 3e-5), (102, 2e-5), (808, 1e-5), (1616, 5e-6))),
    'velocity 2 ms late': _clear(1000, velocity=1e-3, lag=2e-3),
    'velocity 20 ms late': _clear(1000, velocity=1e-3, lag=0.02),
    'velocity 10 ms late 250 Hz': _clear(250, velocity=1e-3, lag=0.01),
    'velocity coherent': _clear(1000, velocity='coherent'),
    'velocity low-passed': _clear(1000, velocity='low-passed'),
    'velocity 2 % off': _clear(1000, velocity='scaled'),
    'velocity true, noisy': _clear(1000, 1e-4, velocity=5e-3),
    'velocity true, exact': _clear(250, 1e-4, velocity=1e-6),
}
"""What real joints and drivers do to a measurement, with stamps that are right."""

ALL = CONDITIONS | STAMPING | MEASURING

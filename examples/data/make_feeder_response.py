"""Makes feeder_response.csv: amplitudes of the empty feeder of full_feeder.toml, with errors of 2 %.

Usage: python examples/data/make_feeder_response.py
"""

import csv
from pathlib import Path

import numpy as np

import vibro

FREQUENCIES = (40, 43, 45, 46, 46.8, 47.4, 48, 48.8, 50, 52, 55)  # [Hz]
SETTING = 0.3  # of what gives 0.35 mm at 50 Hz: 2.5 mm at the peak would break the springs
ERROR = 0.02


def main() -> None:
    feeder = vibro.Machine.magnet(
        trough_mass=6,
        counter_mass=12,
        natural_frequency=47.619,
        damping_ratio=0.015,
        calibration=vibro.Calibration(0.35e-3, 50),
    )
    exact = feeder.response(np.array(FREQUENCIES), setting=SETTING).amplitude
    amplitudes = exact * (1.0 + ERROR * np.random.default_rng(5).standard_normal(exact.size))
    with Path(__file__).with_name("feeder_response.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["frequency_hz", "amplitude_mm", "error_percent"])
        for frequency, amplitude in zip(FREQUENCIES, amplitudes, strict=True):
            table.writerow([frequency, f"{1000 * amplitude:.3g}", 2])


if __name__ == "__main__":
    main()

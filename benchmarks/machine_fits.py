"""Count how often the 95 % intervals of machines that are fitted to amplitudes hold the truth.

For each set of points 2000 draws of noise. An interval should hold the truth in 95 % of them, by chance
+-1 %; in more where it is the bound of the damping, 0, that ends it.

Usage: python benchmarks/machine_fits.py [DRAWS]
"""

from __future__ import annotations

import sys

import numpy as np

from vibro.machines.fitting import Law, fit_response

NATURAL, STATIC = 50.0, 1e-3  # [Hz], [m]
#: Frequencies over the natural one, damping ratio, law, relative error of an amplitude, whether it is stated.
CASES: dict[str, tuple[list[float], float, Law, float, bool]] = {
    "3 on both sides": ([0.94, 0.98, 1.04], 0.04, "constant", 0.02, True),
    "7 on both sides": ([0.97, 0.98, 0.99, 1.0, 1.01, 1.02, 1.03], 0.02, "constant", 0.02, True),
    "7, error from residuals": ([0.97, 0.98, 0.99, 1.0, 1.01, 1.02, 1.03], 0.02, "constant", 0.02, False),
    "5, error from residuals": ([0.95, 0.98, 1.0, 1.02, 1.05], 0.04, "constant", 0.02, False),
    "9 of unbalance, 5 %": ([0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15, 1.2], 0.05, "square", 0.05, True),
    "9, 10 % from residuals": (
        [0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15, 1.2],
        0.05,
        "constant",
        0.1,
        False,
    ),
    "3 below alone": ([0.8, 0.86, 0.9], 0.04, "constant", 0.02, True),
    "5 below alone": ([0.8, 0.84, 0.88, 0.92, 0.95], 0.01, "constant", 0.02, True),
    "6 of unbalance above": ([1.05, 1.2, 1.4, 1.6, 1.8, 2.0], 0.03, "square", 0.02, True),
}


def main() -> None:
    draws, rng = int(sys.argv[1]) if len(sys.argv) > 1 else 2000, np.random.default_rng(1)
    print(f"{'points':26}{'f0':>7}{'zeta':>8}{'static':>8}   estimates given")
    for name, (ratios, damping, law, error, is_stated) in CASES.items():
        x, held, given = np.array(ratios), np.zeros(3), 0
        exact = STATIC * (x**2 if law == "square" else 1.0) / np.hypot(1.0 - x**2, 2.0 * damping * x)
        for _ in range(draws):
            noisy = exact * np.exp(error * rng.standard_normal(x.size))
            points = np.stack([NATURAL * x, noisy], axis=1)
            fit = fit_response(points, law=law, amplitude_error=error if is_stated else None)
            ends = np.array(
                [fit.natural_frequency_interval, fit.damping_ratio_interval, fit.static_amplitude_interval]
            )
            truth = NATURAL, damping, STATIC
            held += (ends[:, 0] <= truth) & (truth <= ends[:, 1])
            given += fit.brackets_peak
        shares = "".join(f"{share:8.1%}" for share in held / draws)
        print(f"{name:25}{shares}   {given / draws:.0%}", flush=True)


if __name__ == "__main__":
    main()

"""Paper J's identification case with scipy.optimize.least_squares: what the fit of hysteron is
measured against. Needs numpy and scipy.

    cargo run --release --example paper_j_data -- DIR
    python3 host-tests/benches/py/fit_paper_j.py DIR

Fits beta, zeta and a_0..a_3 of the rate-dependent Prandtl-Ishlinskii model (J 25, 37, 38) to the
records of role `fit`. Plays start at zero; the last period of each record counts, its residual
weighted by sqrt(A_p). Vectorised over plays and records, with a loop over time only.
"""

import csv
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import scipy
from scipy.optimize import least_squares

PLAYS = np.arange(1, 4)
POINTS_A_PERIOD = 200
A_P = np.array([1.0, 1.56, 2.00])
NAMES = ["beta", "zeta", "a_0", "a_1", "a_2", "a_3"]
START = np.array([1e-4, 5.0, 0.5, 0.2, 0.2, 0.2])
TRUTH = np.array([8.572e-4, 9.715, 0.7236, 0.2906, 0.0416, 0.1512])
RUNS = 15


def read(directory):
    """Drive, rate and displacement, each (samples, records)."""
    data_set = tomllib.loads((directory / "dataset.toml").read_text())
    signals = data_set["signals"]
    columns = [signals[name]["column"] for name in ("time", "input", "output")]
    records = []
    for record in data_set["record"]:
        if record["role"] == "fit":
            with open(directory / record["file"], newline="") as file:
                rows = list(csv.DictReader(file))
            records.append([[float(row[column]) for row in rows] for column in columns])
    t, u, v = (np.ascontiguousarray(column.T) for column in np.array(records).swapaxes(0, 1))
    rate = np.zeros_like(u)
    rate[1:] = np.abs(np.diff(u, axis=0)) / np.diff(t, axis=0)
    return u, rate, v


def residual(p, u, rate, v, weight):
    beta, zeta, a_0, *a = p
    opening = beta * rate[:, :, None] + zeta * PLAYS
    low, high = u[:, :, None] - opening, u[:, :, None] + opening
    z = np.empty_like(low)
    state = np.zeros(low.shape[1:])
    for low_k, high_k, z_k in zip(low, high, z):
        np.minimum(high_k, state, out=z_k)
        np.maximum(low_k, z_k, out=z_k)
        state = z_k
    last = slice(-POINTS_A_PERIOD, None)
    return (weight * (a_0 * u[last] + z[last] @ np.array(a) - v[last])).ravel()


def main():
    u, rate, v = read(Path(sys.argv[1]))
    arguments = (u, rate, v, np.sqrt(A_P))
    print(f"Python {sys.version.split()[0]}, numpy {np.__version__}, scipy {scipy.__version__}")
    at_truth = 0.5 * np.sum(residual(TRUTH, *arguments) ** 2)
    print(f"cost = half the sum of the squared weighted residuals; true parameters: {at_truth:.6f}\n")
    print("| method | fastest ms | median ms | residuals | cost |", " | ".join(NAMES), "|")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for method in ("lm", "trf"):
        times = []
        for _ in range(RUNS):
            calls = 0

            def counted(p):
                nonlocal calls
                calls += 1
                return residual(p, *arguments)

            start = time.perf_counter()
            fit = least_squares(counted, START, method=method, x_scale="jac")
            times.append(1e3 * (time.perf_counter() - start))
        if not fit.success:
            sys.exit(f"{method}: {fit.message}")
        print(
            f"| {method} | {min(times):.1f} | {np.median(times):.1f} | {calls} | {fit.cost:.6f} |",
            " | ".join(f"{value:.6g}" for value in fit.x),
            "|",
        )


if __name__ == "__main__":
    main()

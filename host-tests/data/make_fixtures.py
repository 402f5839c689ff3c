"""Writes the fixtures beside this file: paper J's operators in another language, run once.

    python3 make_fixtures.py        (numpy 1.26 or later)

Equations as in docs/models.md; everything is written out play by play, on purpose without any of
the short cuts that the core takes.
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
P753 = dict(weights=[0.7236, 0.2906, 0.0416, 0.1512], zeta=9.715, beta=8.572e-4)
EXAMPLE_F = dict(
    weights=[0.5] + [0.5 * float(np.exp(-0.31 * i)) for i in range(1, 5)], zeta=3.0, beta=7e-4
)


def operator(weights, thresholds, beta, signal, sample_time, outputs=None, before=None):
    """Rate-dependent Prandtl-Ishlinskii operator; returns the output and the play outputs."""
    plays = [0.0] * len(thresholds) if outputs is None else list(outputs)
    before = signal[0] if before is None else before
    result = []
    for sample in signal:
        rate = abs(sample - before) / sample_time
        before = sample
        total = weights[0] * sample
        for i, threshold in enumerate(thresholds):
            r = threshold + beta * rate
            plays[i] = max(sample - r, min(sample + r, plays[i]))
            total += weights[i + 1] * plays[i]
        result.append(total)
    return np.array(result), plays


def forward(model, drive, sample_time, **kwargs):
    n = len(model["weights"]) - 1
    thresholds = [model["zeta"] * (i + 1) for i in range(n)]
    return operator(model["weights"], thresholds, model["beta"], drive, sample_time, **kwargs)


def inverse(model, reference, sample_time, beta=None):
    a = model["weights"]
    n = len(a) - 1
    sums = np.cumsum(a)
    b = [1 / a[0]] + [1 / sums[i] - 1 / sums[i - 1] for i in range(1, n + 1)]
    r = [model["zeta"] * (i + 1) for i in range(n)]
    s = [a[0] * r[0]]
    for i in range(1, n):
        s.append(s[-1] + sums[i] * (r[i] - r[i - 1]))
    beta = model["beta"] if beta is None else beta
    return operator(b, s, a[0] * beta, reference, sample_time)[0]


def write(path, columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [",".join(columns)]
    for row in zip(*columns.values()):
        rows.append(",".join(repr(float(value)) for value in row))
    path.write_text("\n".join(rows) + "\n")


def references():
    """What `simulate` and `compensate` must yield, a first sample of zero and one far from it."""
    h = 1e-4
    t = np.arange(300) * h
    wave = 30 * np.sin(2 * np.pi * 60 * t) + 8 * np.sin(2 * np.pi * 430 * t)
    for name, model in (("p753", P753), ("example-f", EXAMPLE_F)):
        for start, offset in (("from-zero", 0.0), ("from-35", 35.0)):
            signal = wave + offset
            write(
                HERE / "operators" / f"{name}-{start}.csv",
                {
                    "time_s": t,
                    "signal": signal,
                    "model": forward(model, signal, h)[0],
                    "inverse": inverse(model, signal, h),
                    "rate_independent_inverse": inverse(model, signal, h, beta=0.0),
                },
            )


def loops():
    """Paper J's identification case: steady loops of 200 points, u = 40 sin, noise 0.05 um rms."""
    noise = np.random.default_rng(20130718)
    folder = HERE / "paper-j-loops"
    listing = [
        'name = "Paper J, steady loops of the corrected model"',
        "",
        "[signals]",
        'time   = { column = "time_s", unit = "s" }',
        'input  = { column = "drive_v", unit = "V" }',
        'output = { column = "displacement_um", unit = "um" }',
    ]
    for frequency, role in ((1, "fit"), (50, "fit"), (100, "fit"), (20, "select"), (80, "select"), (60, "report")):
        h = 1 / (200 * frequency)
        drive = 40 * np.sin(2 * np.pi * np.arange(200) / 200)
        _, plays = forward(P753, drive, h)
        # A second period from where the first one ended is the steady loop.
        displacement, _ = forward(P753, drive, h, outputs=plays, before=drive[-1])
        measured = displacement + 0.05 * noise.standard_normal(200)
        name = f"sine_{frequency}hz.csv"
        write(folder / name, {"time_s": np.arange(200) * h, "drive_v": drive, "displacement_um": measured})
        listing += ["", "[[record]]", f'file = "{name}"', f'role = "{role}"']
    (folder / "dataset.toml").write_text("\n".join(listing) + "\n")


references()
loops()

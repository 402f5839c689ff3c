"""Writes numpy/ beside this file: arrays as NumPy itself writes them, run once.

    python3 make_numpy.py        (written by numpy 2.4.6)

The tests know the numbers by the same formulas, exact in every type used.
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent / "numpy"
N = 40
k = np.arange(N)
TIME_MS = 2 * k
TIME_S = k / 512
DRIVE_V = k * k / 8 - 3
DRIVE_MV = 125 * k - 2000
LENGTH_UM = (k % 5) / 4 - k / 16

HERE.mkdir(exist_ok=True)
np.savez(
    HERE / "named.npz",
    time_s=TIME_S,
    drive_v=DRIVE_V.astype(">f4"),
    displacement_um=LENGTH_UM.reshape(1, N),
    note=np.array(["stage A", "µ"]),
    short=np.zeros(N - 1),
    plane=np.zeros((2, 3)),
    scalar=np.float64(1.0),
    phasor=np.zeros(N, dtype=complex),
)
np.savez_compressed(
    HERE / "packed.npz",
    time_ms=TIME_MS.astype("u1"),
    drive_mv=DRIVE_MV.astype("<i2"),
    displacement_um=np.asarray(LENGTH_UM, dtype="<f4"),
)
fields = np.zeros(
    N,
    dtype=np.dtype(
        [("flag", "?"), ("t", ">f8"), ("label", "S3"), ("u", "<i4"), ("pair", "<f4", (2,)), ("y", "<f4")],
        align=True,
    ),
)
fields["t"], fields["u"], fields["y"] = TIME_S, DRIVE_MV, LENGTH_UM
np.save(HERE / "fields.npy", fields)
plain = np.stack([TIME_S, DRIVE_V, LENGTH_UM], axis=1)
np.save(HERE / "plain.npy", plain)
np.save(HERE / "fortran.npy", np.asfortranarray(plain))
np.save(HERE / "lying.npy", np.ascontiguousarray(plain.T)[0])
np.save(HERE / "objects.npy", np.array([1, "a", None], dtype=object))
np.save(HERE / "drive.npy", np.ascontiguousarray(plain[:, :2]))

# As the program writes them.
out = np.zeros(N, dtype=[("time_s", "<f8"), ("drive_v", "<f8")])
out["time_s"], out["drive_v"] = TIME_S, DRIVE_V
np.save(HERE / "out.npy", out)
np.savez(HERE / "out.npz", time_s=TIME_S, drive_v=DRIVE_V)

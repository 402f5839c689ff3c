"""Turns the two original files of the measured piezo stack into a data set.

    python3 prepare_piezo_stack.py Model_Vi_Do.dat Test_Vi_Do_Di.dat DIR/piezo-stack-1hz

The originals are rows of numbers separated by tabs, without a header; the first is the drive in
volts, the fifth the displacement in micrometres. Numbers are copied as they are written. Where the
files come from, and on what terms: README.md beside this script.
"""

import sys
from pathlib import Path

SAMPLES_A_SECOND = 200
DRIVE, DISPLACEMENT = 0, 4

# Name, role, rows. The second file is one run; it is cut at its two rests.
MODEL = [("open_loop_1hz", "fit", range(0, 8027))]
TEST = [
    ("ramp_down", "fit", range(0, 4400)),
    ("ramp_up_down", "select", range(4400, 10700)),
    ("ramp_up", "report", range(10700, 14155)),
]

DESCRIPTION = """\
name = "Multilayer piezo stack (PICMA P-885.91), 1 Hz, measured"

[signals]
time   = { column = "time_s", unit = "s" }
input  = { column = "input_v", unit = "V" }          # before the amplifier, gain not stated
output = { column = "displacement_um", unit = "um", zero = "per-record" } # arbitrary offset
"""


def convert(source, records, folder):
    rows = [line.split("\t") for line in source.read_text().splitlines() if line.strip()]
    expected = records[-1][2].stop
    if len(rows) != expected:
        sys.exit(f"{source}: {len(rows)} rows where {expected} are expected")
    for name, _, at in records:
        lines = ["time_s,input_v,displacement_um"]
        for k in at:
            drive, displacement = rows[k][DRIVE].strip(), rows[k][DISPLACEMENT].strip()
            lines.append(f"{k / SAMPLES_A_SECOND:.6f},{drive},{displacement}")
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", newline="\n")


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    model, test, folder = map(Path, sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    convert(model, MODEL, folder)
    convert(test, TEST, folder)
    records = (f'\n[[record]]\nfile = "{name}.csv"\nrole = "{role}"\n' for name, role, _ in MODEL + TEST)
    (folder / "dataset.toml").write_text(DESCRIPTION + "".join(records), newline="\n")


if __name__ == "__main__":
    main()

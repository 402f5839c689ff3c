#!/usr/bin/env bash
# Makes docs/demo.png from the page of `hysteron demo --seed 8`: loops and the gap, before and after.
# Usage: scripts/readme-picture.sh [PAGE], with chromium and python3.
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
page=${1:-$work/demo/report.html}
if [ $# -eq 0 ]; then
    cargo run --release --locked --quiet -- demo --seed 8 --out "$work/demo" >/dev/null
fi

# The figures as they stand in the page, with its style sheet and markers.
python3 - "$page" "$work/picture.html" <<'PYTHON'
import re
import sys

page = open(sys.argv[1], encoding="utf-8").read()
style = re.search(r"<style>.*?</style>", page, re.S).group()
markers = re.search(r"<body>(<svg.*?</svg>)", page, re.S).group(1)
figures = re.findall(r"<figure.*?</figure>", page, re.S)


def titled(start):
    chosen = [figure for figure in figures if f"<strong>{start}" in figure]
    if len(chosen) != 1:
        sys.exit(f"{len(chosen)} figures titled {start}")
    return re.sub(r'<p class="note">.*?</p>', "", chosen[0], flags=re.S)


chosen = [titled("Loop, raster"), titled("Loop, sine"), titled("The gap")]
with open(sys.argv[2], "w", encoding="utf-8") as out:
    out.write(f'<!DOCTYPE html><meta charset="utf-8">{style}<style>main {{ padding: .5rem 1.5rem; }}'
              f'.plots {{ margin: 0; }}</style>{markers}<main><div class="plots">{"".join(chosen)}</div></main>')
PYTHON

chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$work/profile" \
    --window-size=1048,888 --screenshot=docs/demo.png "file://$work/picture.html" 2>"$work/log" || {
    cat "$work/log" >&2
    exit 1
}

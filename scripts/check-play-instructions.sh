#!/usr/bin/env bash
# Fails when a play of a full plain bank costs more than 17 instructions on a Cortex-M4F.
#
# Compiles scripts/asm-probe for thumbv7em-none-eabihf and looks at the emitted assembly. A play
# takes two comparisons (vcmp), so the piece of straight-line code with the most of them is the full
# bank unrolled, or its loop; its instructions, entry and exit included, are divided by its plays.
# A call, hidden cost that it is, fails too.
#
# See thumb-cargo.sh for the compiler.
set -euo pipefail

limit=17
root=$(cd "$(dirname "$0")/.." && pwd)
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}/asm-probe
assembly=$CARGO_TARGET_DIR/asm_probe.s
mkdir -p "$CARGO_TARGET_DIR"
cd "$root/scripts/asm-probe"

"$root/scripts/thumb-cargo.sh" rustc --quiet --release --locked --lib -- --emit "asm=$assembly"

awk -v limit="$limit" '
    function close_piece() {
        if (compares > most) { most = compares; cost = instructions }
        instructions = compares = 0
    }
    /^[^.[:space:]].*plain_step.*:/ { inside = 1; next }
    !inside { next }
    /^\.Lfunc_end/ { close_piece(); exit }
    /^[^[:space:]].*:/ { close_piece(); next }
    /^[[:space:]]+[a-z]/ {
        instructions++
        if ($1 ~ /^vcmp/) compares++
        if ($1 ~ /^blx?(\.|$)/) { print "plain_step calls " $2; called = 1 }
        if ($1 ~ /^(b|bx|cbn?z|b(eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le))(\.|$)/) close_piece()
    }
    END {
        if (called) exit 1
        if (most < 2) { print "plain_step not found in the assembly"; exit 1 }
        printf "plain bank: %d instructions for %d plays, %.1f a play (at most %d)\n",
            cost, most / 2, cost / (most / 2), limit
        exit cost > limit * most / 2
    }
' "$assembly"

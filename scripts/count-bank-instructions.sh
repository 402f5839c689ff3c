#!/usr/bin/env bash
# Prints the instructions a sample of the plain and the stack bank on an emulated Cortex-M4F.
# Needs qemu-system-arm; see thumb-cargo.sh for the compiler.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}/bank-on-m4f
cd "$root/host-tests/benches/m4f"
"$root/scripts/thumb-cargo.sh" build --quiet --release --locked
exec qemu-system-arm -M netduinoplus2 -display none -monitor none -serial none \
    -semihosting-config enable=on,target=native -icount shift=0,sleep=off \
    -kernel "$CARGO_TARGET_DIR/thumbv7em-none-eabihf/release/bank-on-m4f"

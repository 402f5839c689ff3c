#!/usr/bin/env bash
# Prints the instructions of a compensator step, Rust beside C, on an emulated Cortex-M4F, and fails
# beyond the limits of src/bin/bench.rs.
# Needs qemu-system-arm and arm-none-eabi-gcc; see thumb-cargo.sh for the Rust compiler.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target/thumb}
cd "$root"
scripts/thumb-cargo.sh build --quiet --locked --package hysteron --profile firmware \
    --bin bench --features bench
exec qemu-system-arm -M netduinoplus2 -display none -monitor none -serial none \
    -semihosting-config enable=on,target=native -icount shift=0,sleep=off \
    -kernel "$CARGO_TARGET_DIR/thumbv7em-none-eabihf/firmware/bench"

#!/usr/bin/env bash
# Builds the firmware for both boards and for QEMU and checks it: size, stack, what the sample interrupt
# can reach and what can keep it waiting, and, in the emulator, bit-for-bit agreement with the host,
# instructions, faults, what survives a reset, and the whole way from a recording to a compensated
# reference. Runs the benchmark against C, which has limits, and links the one for a board, which nothing
# here can run.
# Needs qemu-system-arm and gcc-arm-none-eabi; see thumb-cargo.sh for the Rust compiler.
set -euo pipefail

# A ninth and a third of what the part has: docs/hardware.md says what takes it.
flash_limit=$((112 * 1024))
ram_limit=$((48 * 1024))

root=$(cd "$(dirname "$0")/.." && pwd)
thumb=${HYSTERON_THUMB_DIR:-$root/target/thumb}
elf=$thumb/thumbv7em-none-eabihf/firmware/firmware
cd "$root"

code=$(mktemp)
output=$(mktemp)
trap 'rm -f "$code" "$output"' EXIT

for tool in qemu-system-arm arm-none-eabi-gcc arm-none-eabi-objdump arm-none-eabi-size; do
    if ! command -v "$tool" >/dev/null; then
        echo "no $tool: on Debian 'apt-get install --no-install-recommends qemu-system-arm gcc-arm-none-eabi'" >&2
        exit 1
    fi
done

CARGO_TARGET_DIR=$thumb scripts/bench-firmware.sh
CARGO_TARGET_DIR=$thumb scripts/thumb-cargo.sh build --quiet --locked --package hysteron \
    --profile firmware --bin cycles --features bench-board
echo "benchmark for a board: links"

find src host-tests -name '*.rs' -print0 | xargs -0 awk -f scripts/unsafe-reasons.awk

# In the emulator last: the tests use its ELF.
for feature in board-h743 board qemu; do
    CARGO_TARGET_DIR=$thumb scripts/thumb-cargo.sh build --quiet --locked --package hysteron \
        --profile firmware --bin firmware --features "$feature"
    read -r text data bss _ < <(arm-none-eabi-size "$elf" | tail -n 1)
    echo "$feature: $((text + data)) bytes of flash, $((data + bss)) of static RAM"
    if [ $((text + data)) -gt "$flash_limit" ]; then
        echo "more than $flash_limit bytes of flash" >&2
        exit 1
    fi
    arm-none-eabi-objdump -d -C --no-show-raw-insn "$elf" >"$code"
    awk -f scripts/interrupt-paths.awk "$code"
    # The emulator's program formats what it says at its end, through pointers.
    if [ "$feature" = qemu ]; then
        continue
    fi
    awk -f scripts/interrupt-masks.awk "$code"
    said=$(awk -f scripts/stack-depth.awk "$code")
    echo "$said"
    bound=$(sed -n 's/^stack by the calls: \([0-9]*\) bytes.*/\1/p' <<<"$said")
    # The linker made sure of this much.
    room=$((0x$(arm-none-eabi-nm "$elf" | sed -n 's/ A _stack_room$//p')))
    if [ "$bound" -gt "$room" ]; then
        echo "more stack than the $room bytes that src/board/checks.x keeps for it" >&2
        exit 1
    fi
    ram=$((data + bss + bound))
    echo "$feature: $ram bytes of RAM with it"
    if [ "$ram" -gt "$ram_limit" ]; then
        echo "more than $ram_limit bytes of RAM" >&2
        exit 1
    fi
done

HYSTERON_FIRMWARE=$elf cargo test --locked --package hysteron-host --test firmware_emulator \
    --test link_circle --test pil --test faults -- \
    --ignored --nocapture | tee "$output"
stack=$(sed -n 's/.*stack: \([0-9]*\) bytes.*/\1/p' "$output" | sort -n | tail -n 1)
echo "stack: $stack bytes at its deepest in the emulator, of $bound by the calls"
if [ "$stack" -gt "$bound" ]; then
    echo "deeper than the calls allow: scripts/stack-depth.awk misses something" >&2
    exit 1
fi

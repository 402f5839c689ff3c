#!/usr/bin/env bash
# Runs cargo for the microcontroller: thumb-cargo.sh build --profile firmware --bin firmware --features qemu
#
# With rustup's target for thumbv7em-none-eabihf installed it is plain cargo. Without it, where
# Debian's rustc-web, cargo-web and rust-web-src are installed, it builds `core` from their source.
# CARGO_TARGET_DIR chooses where to; target/thumb by default.
set -euo pipefail

target=thumbv7em-none-eabihf
root=$(cd "$(dirname "$0")/.." && pwd)
: "${CARGO_TARGET_DIR:=$root/target/thumb}"
export CARGO_TARGET_DIR
cd "$root"

subcommand=${1:?a cargo command, for example build}
shift

sysroot=$(rustc --print sysroot)
if [ -d "$sysroot/lib/rustlib/$target" ]; then
    exec cargo "$subcommand" --target "$target" --package hysteron "$@"
fi
if [ ! -x /usr/bin/cargo ] || [ ! -d "$(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library/core" ]; then
    echo "no Rust for $target: run 'rustup target add $target'," >&2
    echo "or on Debian 'apt-get install rustc-web cargo-web rust-web-src'" >&2
    exit 1
fi
# Debian has no rust-lld; the one of the host's toolchain links any target.
lld=$(find "$sysroot/lib/rustlib" -name rust-lld -type f -print -quit)
export CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER=${lld:-ld.lld}
exec env -u RUSTUP_TOOLCHAIN PATH=/usr/bin:/bin RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 \
    /usr/bin/cargo "$subcommand" -Zbuild-std=core --target "$target" --package hysteron "$@"

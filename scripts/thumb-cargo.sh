#!/usr/bin/env bash
# cargo for thumbv7em-none-eabihf: `scripts/thumb-cargo.sh build --release ...`, run in the folder of
# a package.
#
# Takes rustup's target where it is installed, else Debian's compiler, which builds `core` itself.
set -euo pipefail

target=thumbv7em-none-eabihf
if [ -d "$(rustc --print target-libdir --target "$target")" ]; then
    exec cargo "$1" --target "$target" "${@:2}"
fi
if ! [ -x /usr/bin/rustc ] || ! [ -d /usr/lib/rustlib/src/rust/library ]; then
    echo "no compiler for $target: 'rustup target add $target'," >&2
    echo "or on Debian 'apt-get install --no-install-recommends rustc-web cargo-web rust-web-src'" >&2
    exit 1
fi
sysroot=$(rustc --print sysroot)
host=$(rustc --print host-tuple)
export CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER=$sysroot/lib/rustlib/$host/bin/rust-lld
exec env PATH=/usr/bin:/bin RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 \
    /usr/bin/cargo "$1" --target "$target" -Zbuild-std=core "${@:2}"

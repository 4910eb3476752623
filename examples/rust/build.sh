#!/bin/sh
# Compiles controller.rs to a shared library: build.sh [LIBRARY]
set -eu
cd "$(dirname "$0")"
if ! command -v rustc > /dev/null; then
    echo "controller.rs needs the Rust compiler, but there is no rustc; install it from https://rustup.rs" >&2
    exit 1
fi
exec rustc --edition 2021 --crate-type cdylib -C opt-level=3 -C panic=abort -o "${1:-controller.so}" controller.rs

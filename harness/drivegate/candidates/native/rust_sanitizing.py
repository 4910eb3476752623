"""A build of a candidate in Rust that looks for what is undefined: the compiler's checks and its address sanitizer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

from drivegate.candidates.candidate import Candidate, Instrumented
from drivegate.candidates.native.compiler import C, found_compiler
from drivegate.candidates.native.rust_build import (
    rust_build,
    rust_compiler,
    second_rust_build,
    stepping_library,
)
from drivegate.candidates.native.sanitizer_runtime import preloaded
from drivegate_models.errors import InputError

_FLAGS: Final = MappingProxyType(
    {
        "address": ("-Zsanitizer=address",),
        # Overflows and shifts, and the conditions of unsafe functions and of pointers.
        "undefined": ("-Cdebug-assertions=on", "-Coverflow-checks=on"),
    }
)
_COMMON: Final = ("-Cdebuginfo=1", "-Cstrip=none", "-Cforce-frame-pointers=yes")


def sanitized_candidate(candidate: Candidate, sanitizers: Sequence[str], folder: Path) -> Candidate:
    """Return a candidate whose processes also run a build with sanitizers."""
    build = rust_build(candidate, "--sanitize")
    compiler = rust_compiler(build, "--sanitize")
    if "float" in sanitizers:
        raise InputError(
            "--sanitize float serves candidates in C and C++, since Rust defines what a float divided by zero is; "
            "leave it out"
        )
    # Where a condition of an unsafe function fails, the line of its call is only in the trace of the panic.
    environment = {"RUST_BACKTRACE": "1"}
    if "address" in sanitizers:
        if not compiler.is_nightly:
            raise InputError(
                f"--sanitize address needs a nightly toolchain of Rust, but rustc is {compiler.release}; install one "
                "(rustup toolchain install nightly) and set RUSTUP_TOOLCHAIN=nightly, or write --sanitize undefined"
            )
        environment |= preloaded(found_compiler(C), C, sanitizers)
    checked = [flag for name in sanitizers for flag in _FLAGS[name]]
    library = second_rust_build(build, (*_COMMON, *checked))
    return replace(
        candidate,
        instrumented=Instrumented(
            "sanitizers",
            folder,
            library,
            environment=tuple(environment.items()),
            stepper=stepping_library(),
        ),
    )

"""Show that processors of different kinds give the same verdict, bit for bit.

    python benchmarks/one_verdict.py reference --effort quick       # content hashes of `drivegate check`
    python benchmarks/one_verdict.py --shards 2 --emulate Nehalem   # also on processors that qemu-x86_64 emulates

Each line is one target: compiled kernels are made for it, and the C library and numpy are kept from instructions that
it has not. With --shards, seeded shards of the search run in one process each, which qemu can emulate; kernels are
compiled before, natively. The exit code is 1 where two differ.
"""

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

_PASSED = ("GLIBC_TUNABLES", "NPY_DISABLE_CPU_FEATURES")
_WITHOUT_AVX = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL,-AVX512DQ",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX2 FMA3 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR",
}
_WITHOUT_AVX512 = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ",
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR",
}


def restrictions() -> dict[str, dict[str, str]]:
    """List the targets that this machine can stand for, with the environment of each."""
    from llvmlite.binding import get_host_cpu_features

    features = get_host_cpu_features()
    targets = {"as it is": {}, "x86-64": _WITHOUT_AVX, "x86-64-v2": _WITHOUT_AVX}
    if features.get("avx2"):
        targets["haswell"] = _WITHOUT_AVX512
    if features.get("avx512vl"):
        targets["skylake-avx512"] = {}
    return {
        name: restricted | ({} if name == "as it is" else {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""})
        for name, restricted in targets.items()
    }


def surroundings(restricted: Mapping[str, str]) -> dict[str, str]:
    """Return the environment of a process, which a candidate's worker gets too."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_CPU_")}
    # numpy warns of every feature that it does not know, which differ by version.
    return {**own, "DRIVEGATE_PASS": ",".join(_PASSED), "PYTHONWARNINGS": "ignore", **restricted}


def digest_of_loops() -> str:
    """Run closed loops of many kinds and draw scenarios, and digest the observed numbers."""
    from drivegate.candidates.kinds import load_controller
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
    from drivegate.drives.running import run_scenario
    from drivegate_cases.drive.drive_document import load_drive

    controller = load_controller(resolve_candidate("reference"))
    drive = load_drive("paper-5-phase")
    sine = drive.replaced(name="sine", emf_shape="sine", emf_flat_deg=None)
    every = fixed_scenarios(drive)
    runs = [*every[3::7], every[4].model_copy(update={"drive": sine})]
    digest = hashlib.sha256()
    for scenario in runs:
        run = run_scenario(scenario, controller)
        digest.update(f"{scenario.name} {run.digest} {run.observed}\n".encode())
    return digest.hexdigest()


def digest_of_shards(shards: int) -> str:
    """Run shards of the search in this process, and digest what they drew and judged."""
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.containment.judge import own_candidate
    from drivegate.gate.shard import DrawnRuns, run_drawn
    from drivegate_cases.drive.drive_document import load_drive

    candidate = own_candidate(resolve_candidate("reference"))
    digest = hashlib.sha256()
    for seed in range(shards):
        outcome = run_drawn(candidate, DrawnRuns(load_drive("paper-5-phase"), seed, 12))
        for run in outcome.runs:
            digest.update(f"{json.dumps(run.scenario, sort_keys=True)} {run.margins}\n".encode())
    return digest.hexdigest()


def checked(words: list[str], restricted: Mapping[str, str]) -> str:
    """Return the content hash of a check in a restricted environment."""
    command = [str(Path(sys.executable).with_name("drivegate")), "check", *words, "--json"]
    done = subprocess.run(
        command, env=surroundings(restricted), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False
    )
    provenance = json.loads(done.stdout)["provenance"]
    return f"{provenance['content_hash'][:16]} on {provenance['target']}"


def here(shards: int, restricted: Mapping[str, str], emulator: tuple[str, ...] = ()) -> str:
    """Return the digest of shards, or of loops, in one process of a restricted environment."""
    command = [*emulator, sys.executable, __file__, "--here", "--shards", str(shards)]
    done = subprocess.run(
        command, env=surroundings(restricted), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True
    )
    return done.stdout.decode().strip()[:16]


def main() -> int:
    """Compute everywhere, and compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--shards", type=int, help="shards of the search in one process, 0 for closed loops alone"
    )
    parser.add_argument("--emulate", action="append", default=[], help="a processor of qemu-x86_64")
    parser.add_argument("--here", action="store_true", help="print the digest of this process alone")
    options, words = parser.parse_known_args()
    if options.here:
        sys.stdout.write(digest_of_shards(options.shards) if options.shards else digest_of_loops())
        return 0
    found = set()

    def report(name: str, compute: Callable[[], str]) -> None:
        began = time.perf_counter()
        answer = compute()
        found.add(answer.partition(" ")[0])
        sys.stdout.write(f"{name:18} {answer}  {time.perf_counter() - began:6.0f} s\n")
        sys.stdout.flush()

    for name, restricted in restrictions().items():
        if options.shards is None:
            report(name, partial(checked, words, restricted))
        else:
            report(name, partial(here, options.shards, restricted))
    for processor in options.emulate:
        emulator = (shutil.which("qemu-x86_64") or "qemu-x86_64", "-cpu", processor)
        report(f"qemu {processor}", partial(here, options.shards or 0, {}, emulator))
    return int(len(found) != 1)


if __name__ == "__main__":
    sys.exit(main())

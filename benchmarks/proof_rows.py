"""The commands whose answers and files `unchanged_results` lists.

Each runs in a folder of its own, which has the files that it is given. What it writes there is compared as well.
"""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

_HERE: Final = Path(__file__).resolve().parent
_EXAMPLES: Final = _HERE.parent / "examples"
_CURRENT_DRIVES: Final = (
    "paper-5-phase",
    "fan-3-phase",
    "traction-7-phase",
    "star-3-phase",
    "star-24v-3-phase",
)
_DUTY_DRIVES: Final = ("pm-ac-surface", "pm-ac-interior", "pm-ac-2kw", "pm-ac-msl", "pm-ac-servo")
_SEEDS: Final = (0, 1, 2)
_DRAWN: Final = 20
_AT_ONCE: Final = 6
_FAULTS: Final = {
    "paper-5-phase": ("power-one-percent-high", "blind-spot", "no-anti-windup"),
    "pm-ac-interior": ("swapped-axes", "late-samples", "patient-stall-watch"),
}
_COMMANDS: Final = (
    *("bench", "campaign", "cases", "check", "checks", "compare", "diff", "drive", "include-dir", "map"),
    *("new", "point", "replay", "report", "reproduce", "selftest", "simulate", "verify"),
)
_QUICK: Final = ("--effort", "quick", "--workers", "1")
_FEW: Final = (*_QUICK, "--only", "CPW-2")
"""Four runs on the paper's drive; the published search fails in all of them."""
_ONE: Final = ("check", "foc", "--drive", "pm-ac-interior", *_QUICK, "--only", "DTM-1")
"""A check of one run."""
_REPORT: Final = "drivegate-report"
_TORQUES: Final = """\
speed_rpm,advance_deg,torque_nm,uncertainty_nm
1500,52,9.8,0.03
1200,40,11.88,0.03
500,,28.648,0.5
"""
_WAIVERS: Final = """\
schema = 1

[[waiver]]
candidate = "published"
check = "CPW-2"
reason = "known"
owner = "control"
margin = -1000.0
expires = 2099-01-01
"""
_RAISING: Final = """\
class Controller:
    def reset(self, nameplate):
        pass

    def step(self, sense):
        raise ValueError(f"no speed at {sense.supply_voltage:.0f} V")
"""

_WRITE_CHANGED: Final = """
import sys
from pathlib import Path
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.drive_file import drive_toml
Path("changed.toml").write_text(drive_toml(load_drive(sys.argv[1]).with_overrides(sys.argv[2:])), encoding="utf-8")
"""
"""Writes the file of a drive with other values."""


@dataclass(frozen=True)
class Row:
    """One command of the list."""

    name: str
    """Its name there."""
    words: tuple[str, ...]
    """What follows `drivegate`."""
    first: tuple[tuple[str, ...], ...] = ()
    """Commands that run before it; `drivegate` and `python` are those of the environment."""
    given: Mapping[str, str] = field(default_factory=dict)
    """Texts of the files that it is given."""
    files: bool = True
    """Whether what it writes is compared."""


def rows() -> Iterator[Row]:
    """List the commands, the cheap ones first."""
    yield Row("cases", ("cases", "--json"))
    yield Row("checks", ("checks", "--json"))
    yield Row("checks duty", ("checks", "--drive", "pm-ac-interior"))
    yield Row("help", ("--help",))
    for name in _COMMANDS:
        yield Row(f"help {name}", (name, "--help"))
    yield from _refusals()
    yield from _templates()
    yield from _files_of_numbers()
    yield from _kinds()
    yield from _options_of_checks()
    yield from _kept_results()
    yield Row("reproduce", ("reproduce", "--json"))
    yield from _faults()
    yield from _studies()
    yield from _checks()


def _checks() -> Iterator[Row]:
    for candidate in ("reference", "published", "initial"):
        for seed in _SEEDS:
            yield _check(candidate, "paper-5-phase", seed)
        for drive in _CURRENT_DRIVES[1:]:
            yield _check(candidate, drive, 0)
    for candidate in ("foc", "direct-torque"):
        for seed in _SEEDS:
            yield _check(candidate, "pm-ac-interior", seed)
    for candidate in ("foc", "inner:pi:reference"):
        for drive in _DUTY_DRIVES:
            if (candidate, drive) != ("foc", "pm-ac-interior"):
                yield _check(candidate, drive, 0)
    for kind in ("c", "python", "numba"):
        yield _check(str(_EXAMPLES / kind / "candidate.toml"), "paper-5-phase", 0, f"example {kind}")
    row = _check("firmware/candidate.toml", "pm-ac-interior", 0, "template embedded-coder")
    yield Row(row.name, row.words, (("drivegate", "new", "embedded-coder", "firmware"),))


def _check(candidate: str, drive: str, seed: int, name: str | None = None) -> Row:
    words = ("check", candidate, "--drive", drive, *_QUICK, "--seed", str(seed), "--json")
    return Row(f"check {name or candidate} {drive} {seed}", words)


def _studies() -> Iterator[Row]:
    duty = ("--case", str(_EXAMPLES / "campaign" / "pm-ac-step-up.toml"))
    for case in ("fig5-search", "lock-up"):
        yield Row(f"simulate {case}", ("simulate", "reference", "--case", case, "--json"))
        yield Row(f"diff {case}", ("diff", "initial", "published", "--case", case, "--json"))
    yield Row("simulate duty", ("simulate", "foc", *duty, "--json"))
    yield Row("diff duty", ("diff", "foc", "foc-mtpa", *duty, "--json"))
    for name, candidates, drives in (
        ("current", ("reference", "initial"), ("paper-5-phase",)),
        ("current drives", ("reference", "initial"), ("paper-5-phase", "star-3-phase")),
        ("duty", ("foc", "direct-torque"), ("pm-ac-interior",)),
        ("duty drives", ("foc", "direct-torque"), ("pm-ac-interior", "pm-ac-surface")),
    ):
        taken = tuple(word for drive in drives for word in ("--drive", drive))
        yield Row(f"compare {name}", ("compare", *candidates, *taken, *_QUICK, "--no-checks", "--json"))
    for campaign in ("spread", "pm-ac"):
        file = str(_EXAMPLES / "campaign" / f"{campaign}.toml")
        yield Row(f"campaign {campaign}", ("campaign", file, "--workers", "1", "--json"))
    for drive in (*_CURRENT_DRIVES, *_DUTY_DRIVES):
        yield Row(f"drive {drive}", ("drive", drive, "--json"))
    axes = ("--speed-rpm", "700,1000", "--torque-nm", "5,9")
    yield Row("map best", ("map", *axes, "--json"))
    yield Row("map reference", ("map", "reference", *axes, "--json"))
    point = ("--speed-rpm", "1500", "--advance-deg", "52", "--torque-nm", "9")
    yield Row("point", ("point", *point, "--json"))
    for candidate, drive in (("published", "paper-5-phase"), ("faulty:swapped-axes", "pm-ac-interior")):
        words = ("drivegate", "check", candidate, "--drive", drive, "--effort", "quick", "--json")
        yield Row(f"replay {drive}", ("replay", _REPORT, "--json"), (words,), files=False)
    for drive, faults in _FAULTS.items():
        named = tuple(word for fault in faults for word in ("--fault", fault))
        yield Row(f"selftest {drive}", ("selftest", "--drive", drive, "--effort", "quick", *named, "--json"))
    for kind in ("half-bridge", "pm-ac"):
        yield Row(f"drawn {kind}", ("selftest", "--drives", str(_DRAWN), "--kind", kind, "--json"))


def _faults() -> Iterator[Row]:
    """Check each faulty controller up to its first failure of the check that must catch it."""
    tables = tomllib.loads((_HERE / "proof_faults.toml").read_text(encoding="utf-8"))
    for drive, names_of in tables.items():
        named, *changes = drive.split(" --set ")
        written = (("python", "-c", _WRITE_CHANGED, named, *changes),) if changes else ()
        for check, names in names_of.items():
            for start in range(0, len(names), _AT_ONCE):
                chosen = (f"faulty:{name}" for name in names[start : start + _AT_ONCE])
                words = ("check", *chosen, "--drive", "changed.toml" if changes else named, *_QUICK)
                words = (*words, "--only", check, "--stop-at-first")
                name = f"faults {drive} {check} {start // _AT_ONCE + 1}"
                yield Row(name, (*words, "--json"), written, files=False)


def _kinds() -> Iterator[Row]:
    """Check candidates of the kinds that `_checks` leaves out, where their compilers are installed."""
    new, paper = ("drivegate", "new"), ("--drive", "paper-5-phase")
    yield Row("kind exec", ("check", "e/candidate.toml", *_FEW, "--json"), ((*new, "exec", "e", *paper),))
    yield Row(
        "kind python of duty ratios",
        ("check", "p/candidate.toml", *_QUICK, "--only", "STP-1", "--json"),
        ((*new, "python", "p"),),
    )
    if shutil.which("cargo"):
        yield Row("kind rust", ("check", "r/candidate.toml", *_FEW, "--json"), ((*new, "rust", "r", *paper),))
    if shutil.which("arm-none-eabi-gcc"):
        yield Row(
            "kind elf", ("check", "m/candidate.toml", *_FEW, "--json"), ((*new, "cortex-m", "m", *paper),)
        )
    yield Row("kind fmu", ("check", "f/candidate.toml", *_FEW, "--json"), ((*new, "fmu", "f", *paper),))
    objects = str(_EXAMPLES / "firmware" / "objects" / "candidate.toml")
    words = ("check", objects, "--drive", "pm-ac-interior", *_QUICK, "--only", "STP-1", "--json")
    yield Row("kind c++", words)
    for part in ("design:golden-section", "near:speed-offset"):
        yield Row(f"kind {part}", ("check", part, *_FEW, "--json"))
    yield Row("kind raising", ("check", "c.py:Controller", *_FEW, "--json"), given={"c.py": _RAISING})


def _options_of_checks() -> Iterator[Row]:
    published = ("check", "published", *_FEW)
    yield Row("check as text", published)
    yield Row("check of two", ("check", "reference", "published", *_FEW, "--json"))
    yield Row("check of advisories", (*published, "--fail-on", "advisory", "--contested", "fail", "--json"))
    before = ("drivegate", "check", "reference", *_FEW, "--output", "before")
    yield Row("check with baseline", (*published, "--baseline", "before/result.json", "--json"), (before,))
    words = (*published, "--fail-on", "advisory", "--waivers", "w.toml", "--json")
    yield Row("check with waivers", words, given={"w.toml": _WAIVERS})
    yield Row("check of last failed", (*published, "--last-failed", "--json"), (("drivegate", *published),))
    corpus = (*published, "--no-search", "--seed", "1", "--corpus", f"{_REPORT}/counterexamples")
    yield Row("check with corpus", (*corpus, "--output", "again"), (("drivegate", *published),))


def _kept_results() -> Iterator[Row]:
    result = f"{_REPORT}/result.json"
    published = ("drivegate", "check", "published", *_FEW)
    duty = ("drivegate", "check", "faulty:swapped-axes", *_ONE[2:-1], "MTP-1", "--stop-at-first")
    for name, first in (("current", published), ("duty", duty)):
        yield Row(f"report {name}", ("report", result, "--output", "again", "--json"), (first,))
    yield Row("verify", ("verify", result), (("drivegate", *_ONE),), files=False)
    key, public = ("openssl", "genpkey", "-algorithm", "ed25519", "-out", "key.pem"), "public.pem"
    keys = (key, ("openssl", "pkey", "-in", "key.pem", "-pubout", "-out", public))
    signed = (*keys, ("drivegate", *_ONE, "--sign", "key.pem"))
    yield Row("verify signed", ("verify", result, "--key", public, "--json"), signed, files=False)
    altered = f"from pathlib import Path; p = Path('{result}'); p.write_text(p.read_text().replace('foc', 'fok', 1))"
    yield Row(
        "verify altered", ("verify", result), (("drivegate", *_ONE), ("python", "-c", altered)), files=False
    )
    found = f"{_REPORT}/counterexamples/CPW-2.json"
    yield Row("replay one", ("replay", found, "--plot", "run.svg"), (published,))
    yield Row(
        "replay fixed", ("replay", found, "--candidate", "reference", "--json"), (published,), files=False
    )
    taken = ("simulate", "reference", "--from", _REPORT, "--run", "CPW-2", "--csv", "run.csv", "--json")
    yield Row("simulate from report", taken, (published,))


def _files_of_numbers() -> Iterator[Row]:
    files = ("--csv", "t.csv", "--parquet", "t.parquet", "--plot", "t.svg")
    duty = ("--case", str(_EXAMPLES / "campaign" / "pm-ac-step-up.toml"))
    yield Row("trace current", ("simulate", "reference", "--case", "fig5-search", *files))
    yield Row("trace duty", ("simulate", "foc", *duty, *files))
    changed = ("--drive", "star-3-phase", "--set", "machine.resistance_ohm=0.1")
    yield Row("trace star", ("simulate", "published", "--case", "fig5-search", *changed, *files))
    yield Row("map files", ("map", "--speed-rpm", "700,1000", "--torque-nm", "5,9", *files))
    plant = ("--speed-rpm", "700,1000", "--advance-deg", "0,20", "--current-a", "10")
    yield Row("map plant", ("map", *plant, "--parameter", "resistance=1,1.4", *files))
    differing = ("diff", "initial", "published", "--case", "lock-up", "--tolerance", "1e-3", "--before", "2")
    yield Row("diff plot", (*differing, "--ignore", "input_power", "--plot", "d.svg"))
    for drive in ("paper-5-phase", "pm-ac-interior"):
        yield Row(f"drive plot {drive}", ("drive", drive, "--plot", "d.svg"))
    fit = ("drive", "--fit", "torques.csv", "--keep", "resistance_ohm", "--json")
    yield Row("drive fit", fit, given={"torques.csv": _TORQUES})
    point = ("point", "--speed-rpm", "700", "--advance-deg", "5", "--current-a", "12", "--cycles", "50")
    yield Row("point transient", (*point, "--drive", "star-3-phase"))


def _templates() -> Iterator[Row]:
    kinds = ("python", "numba", "c", "rust", "cortex-m", "exec", "embedded-coder")
    for kind in kinds:
        yield Row(f"new {kind}", ("new", kind, "mine"))
    yield Row("new drive", ("new", "drive", "mine.toml"))
    yield Row("new drive duty", ("new", "drive", "mine.toml", "--drive", "pm-ac-interior", "--json"))


def _refusals() -> Iterator[Row]:
    """Commands that end with exit code 2; their sentence is compared with the wording."""
    manifest = 'schema = 1\nname = "mine"\nkind = "python"\nentry = "c.py:Controller"\n'
    for name, words, given in (
        ("missing file", ("check", "nothing.toml"), {}),
        ("no TOML", ("check", "m.toml"), {"m.toml": "schema = = 1\n"}),
        ("manifest key", ("check", "m.toml"), {"m.toml": f"{manifest}estimate_power = true\n"}),
        ("manifest kind", ("check", "m.toml"), {"m.toml": manifest.replace("python", "pyton")}),
        ("manifest entry", ("check", "m.toml"), {"m.toml": manifest}),
        ("candidate", ("check", "refrence"), {}),
        ("fault", ("check", "faulty:no-integrl"), {}),
        ("design", ("check", "design:golden"), {}),
        ("near", ("check", "near:nothing"), {}),
        ("contract", ("check", "foc", "--drive", "paper-5-phase"), {}),
        ("check", ("check", "reference", "--only", "CNV-9"), {}),
        ("option", ("check", "reference", "--efort", "quick"), {}),
        ("effort", ("check", "reference", "--effort", "huge"), {}),
        ("waivers", ("check", "reference", "--waivers", "w.toml"), {"w.toml": "schema = 1\n[[waiver]]\n"}),
        ("drive", ("drive", "paper-6-phase"), {}),
        ("drive unit", ("drive", "--set", "machine.inductance_h=2.88"), {}),
        ("drive key", ("drive", "--set", "machine.inductance=2.88"), {}),
        ("drive value", ("drive", "--set", "machine.phases=-5", "--json"), {}),
        ("drive file", ("drive", "d.toml"), {"d.toml": 'schema = 1\nname = "d"\nkind = "half-brige"\n'}),
        ("fit", ("drive", "--fit", "t.csv"), {"t.csv": "speed_rpm,torque\n1500,9.8\n"}),
        ("scenario", ("simulate", "reference", "--case", "s.toml"), {"s.toml": "schema = 2\nduration = 1\n"}),
        ("case", ("simulate", "reference", "--case", "lockup"), {}),
        ("campaign", ("campaign", "c.toml"), {"c.toml": 'schema = 1\nname = "c"\ncandidate = []\n'}),
        ("axis", ("map", "--speed-rpm", "fast", "--torque-nm", "5"), {}),
        ("point", ("point", "--speed-rpm", "1500", "--advance-deg", "52"), {}),
        ("result", ("report", "r.json"), {"r.json": '{"schema": 2, "kind": "check"}\n'}),
        ("counterexample", ("replay", "r.json"), {"r.json": '{"schema": 1}\n'}),
        ("verify", ("verify", "r.json"), {"r.json": "[]\n"}),
        ("command", ("chek", "reference"), {}),
        ("selftest", ("selftest", "--fault", "nothing"), {}),
        ("bench", ("bench", "--only", "nothing"), {}),
        ("new", ("new", "python", "mine"), {"mine/c.py": "\n"}),
    ):
        yield Row(f"refused {name}", words, given=given)

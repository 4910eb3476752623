"""Only a contract's folder and the kinds of drives know which contract or kind they have; the rest asks it."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ASKS = re.compile(
    r"isinstance\(.*PmAcDocument|contract [!=]= \"|kind(?:\"\])? [!=]= (?:PM_AC|\"(?:pm-ac|star|half-bridge)\")"
)
KNOWN = {
    "drivegate/commands/diff.py",
    "drivegate/scenarios/traits.py",
    "drivegate_cases/drive/document.py",
}
"""Modules that ask: two of the harness, and the document that declares what such a drive has."""


def test_nothing_else_asks_which_contract_or_kind_it_has() -> None:
    asking = {
        path.relative_to(ROOT / package).as_posix()
        for package in ("harness", "reports", "reference_cases")
        for path in (ROOT / package).rglob("*.py")
        if "templates" not in path.parts and ASKS.search(path.read_text(encoding="utf-8"))
    }
    own = ("drivegate/contracts/", "drivegate/drives/")
    assert {path for path in asking if not path.startswith(own)} <= KNOWN


def test_documents_import_nothing_by_name() -> None:
    files = (ROOT / "reference_cases").rglob("*.py")
    hidden = [path.name for path in files if "import_module" in path.read_text(encoding="utf-8")]
    assert not hidden, f"{hidden} hide an import, and with it perhaps a circle"

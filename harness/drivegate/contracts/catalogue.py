"""All contracts, and the checks of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Final

from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.checks.check import Check
    from drivegate.contracts.comparison import Comparison
    from drivegate.contracts.contract import Contract
    from drivegate_cases.drive.drive_document import DriveDocument

TEXTS: Final = ("requirement", "limit", "scenarios", "formula", "why")
"""Texts of a check that name a drive's numbers."""


def _current() -> Contract:
    from drivegate.contracts.current.contract import CURRENT

    return CURRENT


def _duty() -> Contract:
    from drivegate.contracts.duty.contract import DUTY

    return DUTY


CONTRACTS: Final[Mapping[str, Callable[[], Contract]]] = {"current": _current, "duty": _duty}
"""What imports each contract, by its name."""


def contract_named(name: str) -> Contract:
    return CONTRACTS[name]()


def contract_of(drive: DriveDocument) -> Contract:
    """Return the contract of the controllers that a drive takes."""
    return contract_named(drive.contract)


def all_contracts() -> tuple[Contract, ...]:
    """Return every contract, in the order in which they are listed."""
    return tuple(map(contract_named, CONTRACTS))


@cache
def all_checks() -> dict[str, Check]:
    """Return a check for each identifier; where several contracts have it, that of the first."""
    found: dict[str, Check] = {}
    for contract in all_contracts():
        for check in contract.checks:
            found.setdefault(check.id, check)
    for contract in all_contracts():
        for check in _installed(contract.name):
            if found.setdefault(check.id, check) is not check:
                raise InputError(
                    f"an installed package offers a check {one_line(check.id)}, which there is already; give it "
                    "another identifier"
                )
    return found


def checks_of(drive: DriveDocument, declaration: Declaration) -> tuple[Check, ...]:
    """Return the checks of a candidate on a drive: of the contract, of installed packages, and the user's rows."""
    return contract_of(drive).checks + _installed(drive.contract) + row_checks(drive.contract, declaration)


def applicable_checks(drive: DriveDocument, declaration: Declaration) -> tuple[Check, ...]:
    """Return those of them that apply to the drive and the candidate."""
    checks = checks_of(drive, declaration)
    return tuple(check for check in checks if check.reason_not_applicable(declaration, drive) is None)


def _installed(contract: str) -> tuple[Check, ...]:
    # It brings the documents of drives, which the names of contracts do not need.
    from drivegate.checks.installed import installed_checks

    return installed_checks(contract)


def row_checks(contract: str, declaration: Declaration) -> tuple[Check, ...]:
    """Return the checks that a user's rows are under a contract."""
    if declaration.requirements is None:
        return ()
    from drivegate.contracts.rows.checks import row_check

    return tuple(row_check(contract_named(contract), row) for row in declaration.requirements.rows)


def check_of(contract: str, name: str, declaration: Declaration = NOTHING_DECLARED) -> Check:
    """Return a contract's check or a user's row by its identifier, else a check of another contract."""
    listed = contract_named(contract).checks + _installed(contract)
    own = listed + row_checks(contract, declaration)
    return next((check for check in own if check.id == name), None) or all_checks()[name]


def comparison_of(kind: object) -> Comparison:
    """Return how the controllers of a comparison were compared, by the kind of its document."""
    made = [contract.comparison() for contract in all_contracts()]
    found = next((comparison for comparison in made if comparison.kind == kind), None)
    if found is None:
        kinds = " or ".join(f"'{comparison.kind}'" for comparison in made)
        raise InputError(f"the document is of kind {kind!r}, but must be of kind {kinds}")
    return found


_KEPT: Final = 1_000


@lru_cache(maxsize=_KEPT)
def on_drive(check: Check, drive: DriveDocument, declaration: Declaration = NOTHING_DECLARED) -> Check:
    """Return a check whose texts have the numbers of a drive, and those that a candidate declares."""
    numbers = contract_of(drive).numbers(drive, declaration)
    return replace(check, **{name: getattr(check, name).format_map(numbers) for name in TEXTS})

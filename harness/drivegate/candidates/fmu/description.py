"""Reading what an unpacked FMU says of itself in its `modelDescription.xml`."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from xml.parsers import expat

from drivegate.candidates.fmu.variables import REAL, Connections, Mismatch, Ports, Variable, connections_of
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

DESCRIPTION: Final = "modelDescription.xml"
_MOST_BYTES: Final = 64 * 2**20
_IDENTIFIER: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_FAILURES: Final = re.compile("error|fatal|warn", re.IGNORECASE)


@dataclass(frozen=True)
class FmuDescription:
    version: int
    """Version of FMI: 2 or 3."""
    identifier: str
    """Name of its library, without a suffix."""
    token: str
    """What ties the library to the description."""
    only_once: bool
    """Whether a process may have only one instance of it at a time."""
    log_categories: tuple[str, ...]
    """Categories of messages that report errors."""
    connections: Connections
    """Which of its variables carry what."""


def read_description(file: Path, folder: Path) -> FmuDescription:
    stated_version, log_categories = _outline(file, folder / DESCRIPTION)
    version = _version_of(file, stated_version)
    model = _model_description(file, folder / DESCRIPTION)
    slave = model.coSimulation
    if slave is None:
        kinds = {"model exchange": model.modelExchange, "scheduled execution": model.scheduledExecution}
        has = (
            " and ".join(kind for kind, given in kinds.items() if given is not None)
            or "nothing that can be run"
        )
        raise InputError(f"{shown_path(file)} is an FMU for {has}; export it for co-simulation")
    if slave.needsExecutionTool:
        raise InputError(
            f"{shown_path(file)} needs the tool that exported it to run (needsExecutionTool); export it with its code "
            "in it, as a stand-alone FMU"
        )
    identifier = str(slave.modelIdentifier)
    if not _IDENTIFIER.fullmatch(identifier):
        raise InputError(
            f"{shown_path(file)}: the modelIdentifier in {DESCRIPTION} is '{one_line(identifier)}', but must be a "
            "name as in C"
        )
    try:
        connections = connections_of(_variables(model), version)
    except Mismatch as error:
        raise InputError(
            f"{shown_path(file)} is no controller: {error}; {_required(error.ports, version)}"
        ) from error
    return FmuDescription(
        version,
        identifier,
        str(model.guid),
        bool(slave.canBeInstantiatedOnlyOncePerProcess),
        tuple(filter(_FAILURES.search, log_categories)),
        connections,
    )


class _HasDocumentType(Exception):
    """Raised at the first sign of a document type."""


def _outline(file: Path, description: Path) -> tuple[str, list[str]]:
    """Read FMI's version and the categories of messages, and refuse what a library for XML should not be given."""
    if not description.is_file():
        raise InputError(
            f"{shown_path(file)} has no {DESCRIPTION} in it, which every FMU has; name a file that a tool exported "
            "as an FMU"
        )
    if description.stat().st_size > _MOST_BYTES:
        raise InputError(
            f"{shown_path(file)}: {DESCRIPTION} has more than {_MOST_BYTES // 2**20} MiB; export fewer variables"
        )
    try:
        return _parsed(description)
    except (expat.ExpatError, ValueError) as error:
        raise InputError(
            f"{shown_path(file)}: {DESCRIPTION} is no valid XML: {one_line(str(error))}; export the FMU again"
        ) from error
    except _HasDocumentType:
        raise InputError(
            f"{shown_path(file)}: {DESCRIPTION} has a document type, which may define entities of any size; an FMU's "
            "has none"
        ) from None


def _parsed(description: Path) -> tuple[str, list[str]]:
    roots: list[dict[str, str]] = []
    categories: list[str] = []

    def refuse(*_: object) -> None:
        raise _HasDocumentType

    def element(name: str, attributes: dict[str, str]) -> None:
        if not roots:
            roots.append(attributes)
        if name == "Category":
            categories.append(attributes.get("name", ""))

    parser = expat.ParserCreate()
    # Refused at its start, before the parser expands any entity that it defines.
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = element
    with description.open("rb") as stream:
        parser.ParseFile(stream)
    return roots[0].get("fmiVersion", ""), categories


def _version_of(file: Path, text: str) -> int:
    if text == "2.0" or re.fullmatch(r"3\.0(\.\d+)?", text):
        return int(text[0])
    raise InputError(
        f"{shown_path(file)} is of FMI version '{one_line(text)}'; export it for FMI 2.0 or 3.0 (co-simulation)"
    )


def _model_description(file: Path, description: Path) -> Any:
    """Read the description even where it breaks a rule of FMI that does not matter here."""
    from fmpy import read_model_description

    try:
        return read_model_description(str(description))
    except Exception as error:
        problems = getattr(error, "problems", None) or [f"{type(error).__name__}: {error}"]
        problem = one_line(str(problems[0]))[:300].rstrip(". ")
    try:
        return read_model_description(str(description), validate=False)
    except Exception as error:
        raise InputError(
            f"{shown_path(file)}: {DESCRIPTION} is not as FMI requires: {problem}; correct it, or export the FMU again"
        ) from error


def _variables(model: Any) -> Iterator[Variable]:
    for variable in model.modelVariables:
        shape = tuple(int(size) for size in variable.shape or ())
        yield Variable(
            str(variable.name),
            int(variable.valueReference),
            str(variable.causality),
            str(variable.type),
            shape,
        )


def _required(ports: Ports, version: int) -> str:
    """State which variables a controller has."""
    real = REAL[version]
    needs = f"{real} input{'s' if len(ports.inputs) > 1 else ''} {', '.join(ports.inputs)}"
    answers = f"{real} outputs {' and '.join((*(_elements(name) for name in ports.arrays), *ports.outputs))}"
    may_take = " and ".join((", ".join(ports.more_inputs), *map(_elements, ports.input_arrays)))
    may_answer = ", ".join((*(_elements(name) for name in ports.more_arrays), *ports.more_outputs))
    plural = "s" if ports.more_arrays or len(ports.more_outputs) > 1 else ""
    return (
        f"a controller has the {needs} and the {answers}, and may have the inputs {may_take}, the output{plural} "
        f"{may_answer} and parameters named like the nameplate's fields"
    )


def _elements(name: str) -> str:
    return f"{name}[1], {name}[2] and so on"

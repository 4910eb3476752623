"""Build an FMU from a controller in C that implements the functions of drivegate.h or of drivegate_duty.h.

    python build_fmu.py controller.c                      # controller.fmu, for FMI 2.0
    python build_fmu.py firmware.c --contract duty        # of a controller that answers with duty ratios
    python build_fmu.py controller.c tables.c --fmi 3 --output mine.fmu

It needs a C compiler, drivegate for drivegate.h and fmpy for the headers of FMI. The FMU has code for the platform
on which it is built, and the same sources give the same FMU, but for what the compiler does.
"""

import argparse
import ctypes
import hashlib
import platform
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
WRAPPER = ("instance.h", "instance.c", "signals.h", "current_signals.c", "duty_signals.c", "fmi2.c", "fmi3.c")


class Variable(NamedTuple):
    """A variable of the FMU; its value reference is that of the contract's signals."""

    name: str
    reference: int
    causality: str
    kind: str = "real"
    width: int = 1
    """Values of an array, which has a value reference for each where the version of FMI knows no arrays."""


def numbered(first: int, causality: str, names: str, kind: str = "real") -> tuple[Variable, ...]:
    """Number variables from a value reference on."""
    return tuple(
        Variable(name, reference, causality, kind) for reference, name in enumerate(names.split(), first)
    )


def variables_of(contract: str, phases: int, estimates_power: bool) -> tuple[Variable, ...]:
    """List the variables of a controller, as its signals have them."""
    if contract == "duty":
        return (
            *numbered(
                1,
                "input",
                "reference supply_voltage supply_current angle speed hall encoder_count trip enable "
                "source_current winding_temperature",
            ),
            Variable("phase_currents", 101, "input", width=3),
            Variable("phase_voltages", 131, "input", width=3),
            Variable("mean_voltages", 141, "input", width=3),
            Variable("duty_ratios", 111, "output", width=3),
            Variable("legs", 121, "output", width=3),
            *numbered(16, "output", "next_period torque input_power fault brake_duty"),
            *numbered(
                21,
                "parameter",
                "kind reference_kind pole_pairs updates update_delay control_every position is_reversing",
                "integer",
            ),
            *numbered(
                31,
                "parameter",
                "nominal_supply_voltage base_speed highest_speed rated_power current_limit control_period dead_time "
                "resistance direct_inductance quadrature_inductance magnet_flux inertia core_loss_conductance "
                "switch_drop diode_drop position_error link_capacitance source_resistance link_limit charge_limit "
                "discharge_limit chopper_voltage chopper_resistance least_speed start_time heat_capacity "
                "thermal_resistance ambient_temperature temperature_limit temperature_coefficient temperature_lag "
                "voltage_filter",
            ),
        )
    outputs = "current_reference advance_angle" + (" input_power" if estimates_power else "")
    return (
        *numbered(1, "input", "speed_reference speed current_magnitude_sum half_supply_voltage"),
        Variable("phase_currents", 101, "input", width=phases),
        *numbered(11, "output", outputs),
        *numbered(21, "parameter", "phases pole_pairs kind", "integer"),
        *numbered(
            31,
            "parameter",
            "nominal_half_supply_voltage base_speed rated_power current_limit control_period hysteresis_band "
            "resistance inductance emf_constant inertia window conducting_phases advance_start advance_slope "
            "highest_speed",
        ),
    )


def build_fmu(
    sources: list[Path],
    output: Path,
    *,
    fmi: int = 2,
    phases: int = 5,
    estimates_power: bool = False,
    contract: str = "current",
) -> Path:
    """Compile a controller with its wrapper and pack both with the description into an FMU.

    Parameters
    ----------
    sources : list of Path
        The controller's C files; the first one gives the FMU its model's name.
    output : Path
        The FMU to write.
    fmi : int
        Version of FMI: 2 or 3.
    phases : int
        Number of phases of the drive, which is the number of phase currents.
    estimates_power : bool
        Whether the controller gives an estimate of its input power; one of duty ratios always may.
    contract : str
        What the controller answers with: ``current``, by drivegate.h, or ``duty``, by drivegate_duty.h.

    Returns
    -------
    Path
        The FMU.
    """
    model = re.sub(r"\W", "_", sources[0].stem)
    token = token_of(
        [*sources, *(HERE / name for name in WRAPPER)], f"{fmi} {phases} {estimates_power} {contract}"
    )
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / f"{model}{library_suffix()}"
        compile_library(sources, library, fmi, contract, phases, token)
        only_once = ctypes.CDLL(str(library)).drivegate_state_size() == 0
        variables = variables_of(contract, phases, estimates_power)
        describe = description_2 if fmi == 2 else description_3
        pack(output, describe(model, token, variables, only_once), library, platform_folder(fmi))
    return output


def token_of(files: list[Path], options: str) -> str:
    """Make a token that ties the description to its library."""
    digest = hashlib.sha256(options.encode())
    for file in files:
        digest.update(file.read_bytes())
    return "{" + digest.hexdigest()[:32] + "}"


def compile_library(
    sources: list[Path], library: Path, fmi: int, contract: str, phases: int, token: str
) -> None:
    """Compile with the system's compiler; its own messages say what is wrong."""
    command = ["cc", "-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden"]
    chosen = "-DCONTROLLER_DUTY" if contract == "duty" else f"-DCONTROLLER_PHASES={phases}"
    command += [chosen, f'-DFMU_TOKEN="{token}"']
    command += [
        f"-I{folder}"
        for folder in (
            HERE,
            header_folder("drivegate_models", "contract/include"),
            header_folder("fmpy", "c-code"),
        )
    ]
    wrapper = ("instance.c", f"{contract}_signals.c", f"fmi{fmi}.c")
    command += [str(file) for file in (*sources, *(HERE / name for name in wrapper))]
    subprocess.run([*command, "-o", str(library), "-lm"], check=True)


def header_folder(package: str, folder: str) -> Path:
    """Find the headers that a Python package brings."""
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise SystemExit(
            f"{sys.executable} has no {package}; activate drivegate's environment with drivegate[fmu]"
        )
    return Path(spec.submodule_search_locations[0]) / folder


def library_suffix() -> str:
    """Return how shared libraries are called here."""
    return ".dylib" if sys.platform == "darwin" else ".so"


def platform_folder(fmi: int) -> str:
    """Return the folder for binaries of this platform."""
    system = "darwin" if sys.platform == "darwin" else "linux"
    machine = {"arm64": "aarch64", "amd64": "x86_64"}.get(platform.machine().lower(), platform.machine())
    return f"{system}64" if fmi == 2 else f"{machine}-{system}"


def description_2(
    model: str, token: str, variables: tuple[Variable, ...], only_once: bool
) -> ElementTree.Element:
    """Describe the FMU as FMI 2.0 has it."""
    root = ElementTree.Element("fmiModelDescription", fmiVersion="2.0", modelName=model, guid=token)
    slave = ElementTree.SubElement(root, "CoSimulation", modelIdentifier=model)
    if only_once:
        slave.set("canBeInstantiatedOnlyOncePerProcess", "true")
    add_log_categories(root)
    listed = ElementTree.SubElement(root, "ModelVariables")
    single = [element for variable in variables for element in elements_of(variable)]
    for variable in single:
        scalar = ElementTree.SubElement(
            listed,
            "ScalarVariable",
            name=variable.name,
            valueReference=str(variable.reference),
            causality=variable.causality,
            variability="fixed" if variable.causality == "parameter" else "discrete",
        )
        value = ElementTree.SubElement(scalar, "Real" if variable.kind == "real" else "Integer")
        if variable.causality != "output":
            value.set("start", "0")
    structure = ElementTree.SubElement(root, "ModelStructure")
    for group in ("Outputs", "InitialUnknowns"):
        unknowns = ElementTree.SubElement(structure, group)
        for place, variable in enumerate(single, 1):
            if variable.causality == "output":
                ElementTree.SubElement(unknowns, "Unknown", index=str(place))
    return root


def elements_of(variable: Variable) -> list[Variable]:
    """Return the elements of an array one by one; a variable of one value is its own."""
    if variable.width == 1:
        return [variable]
    return [
        variable._replace(name=f"{variable.name}[{place + 1}]", reference=variable.reference + place, width=1)
        for place in range(variable.width)
    ]


def description_3(
    model: str, token: str, variables: tuple[Variable, ...], only_once: bool
) -> ElementTree.Element:
    """Describe the FMU as FMI 3.0 has it."""
    root = ElementTree.Element(
        "fmiModelDescription", fmiVersion="3.0", modelName=model, instantiationToken=token
    )
    slave = ElementTree.SubElement(root, "CoSimulation", modelIdentifier=model)
    if only_once:
        slave.set("canBeInstantiatedOnlyOncePerProcess", "true")
    add_log_categories(root)
    listed = ElementTree.SubElement(root, "ModelVariables")
    ElementTree.SubElement(listed, "Float64", name="time", valueReference="0", causality="independent")
    for variable in variables:
        value = ElementTree.SubElement(
            listed,
            "Float64" if variable.kind == "real" else "Int64",
            name=variable.name,
            valueReference=str(variable.reference),
            causality=variable.causality,
            variability="fixed" if variable.causality == "parameter" else "discrete",
        )
        if variable.causality != "output":
            value.set("start", " ".join(["0"] * variable.width))
        if variable.width > 1 or variable.name == "phase_currents":
            ElementTree.SubElement(value, "Dimension", start=str(variable.width))
    structure = ElementTree.SubElement(root, "ModelStructure")
    for group in ("Output", "InitialUnknown"):
        for output in (variable for variable in variables if variable.causality == "output"):
            ElementTree.SubElement(structure, group, valueReference=str(output.reference))
    return root


def add_log_categories(root: ElementTree.Element) -> None:
    """State that errors are reported."""
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(categories, "Category", name="logStatusError")


def pack(output: Path, description: ElementTree.Element, library: Path, folder: str) -> None:
    """Write the archive, with the same time in every entry."""
    ElementTree.indent(description)
    text = ElementTree.tostring(description, encoding="UTF-8", xml_declaration=True)
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in (
            ("modelDescription.xml", text),
            (f"binaries/{folder}/{library.name}", library.read_bytes()),
        ):
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)


def main() -> None:
    """Build the FMU that the command line requests."""
    parser = argparse.ArgumentParser(description="Build an FMU from a drivegate controller in C.")
    parser.add_argument("sources", nargs="+", type=Path, help="the controller's C files")
    parser.add_argument("--output", type=Path, help="the FMU to write; otherwise named like the first source")
    parser.add_argument("--fmi", type=int, choices=(2, 3), default=2, help="version of FMI")
    parser.add_argument("--phases", type=int, default=5, help="number of phases of the drive")
    parser.add_argument(
        "--estimates-power", action="store_true", help="the controller estimates its input power"
    )
    parser.add_argument(
        "--contract", choices=("current", "duty"), default="current", help="what the controller answers with"
    )
    options = parser.parse_args()
    output = options.output or Path(f"{options.sources[0].stem}.fmu")
    try:
        build_fmu(
            options.sources,
            output,
            fmi=options.fmi,
            phases=options.phases,
            estimates_power=options.estimates_power,
            contract=options.contract,
        )
    except subprocess.CalledProcessError as error:
        raise SystemExit("the controller does not compile") from error
    print(output)


if __name__ == "__main__":
    main()

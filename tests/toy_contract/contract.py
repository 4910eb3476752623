"""The contract, and its entries in the tables of contracts, kinds of drives and kinds of candidates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.toy_contract.controllers import KIND
from tests.toy_contract.motor import COMMAND, DRIVE_FILE, SENSE, ToyRun, ToySense, called, run_motor

from drivegate.candidates.kinds import KINDS
from drivegate.checks.check import Check, Record, Unseen
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.catalogue import CONTRACTS
from drivegate.contracts.comparison import (
    DRIVE_POINT,
    HELD,
    POINTS,
    RANKING,
    Comparison,
    Figure,
    PlannedRun,
    Ranking,
    RunTable,
    Section,
    mean_of,
    name_of,
)
from drivegate.contracts.contract import Contract, RecordedTrace, Witness
from drivegate.drives.abilities import ABILITIES
from drivegate.drives.ability import Ability, RunTime
from drivegate.drives.constant_power import ConstantPower
from drivegate.drives.kinds import DRIVE_KINDS, DriveKind
from drivegate.drives.power_reach import PowerReach
from drivegate.scenarios.drawn_range import DrawnRange, Interval
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.layout import Layout
from drivegate_models.units import RPM

SPEEDS = (100.0, 300.0)


def scenario_at(drive: Any, speed_rpm: float) -> Scenario:
    load = ConstantTorqueLoad(kind="constant_torque", torque_nm=1.0, factor=((0.0, 1.0),))
    return Scenario(
        name=f"{speed_rpm:g}rpm", drive=drive, duration_s=0.5, speed_rpm=((0.0, speed_rpm),), load=load
    )


def error_rpm(run: ToyRun) -> float:
    return abs(float(run.trace[-1, 1]) * RPM - run.scenario.speed_rpm[-1][1])


def speed_margin(record: Record) -> Margin:
    error = error_rpm(record.run)  # type: ignore[arg-type]
    return Margin("TOY-1", at_most(error, 1.0), f"speed error {error:.3g} rpm")


CHECK = Check(
    id="TOY-1",
    requirement="The speed reaches its reference.",
    source="P1",
    level="required",
    limit="{error} rpm",
    scenarios="every run",
    formula="error over limit",
    why="A drive that misses its speed is of no use.",
    evaluate=speed_margin,
)


class ToySteps:
    """Steps through given senses."""

    def __init__(self, controller: Any, stated: dict[str, float]) -> None:
        self._controller, self._stated = controller, stated
        self.last_answers = np.empty(0, COMMAND)
        self.restart()

    def restart(self) -> None:
        self._controller.reset(self._stated)

    def answers(self, senses: NDArray[Any], _currents: NDArray[np.float64]) -> NDArray[Any]:
        commands, step = np.zeros(len(senses), COMMAND), called(self._controller)
        commands["struct_size"] = COMMAND.itemsize
        for place in range(len(senses)):
            step(senses[place : place + 1], commands[place : place + 1])
        return commands


def figures(planned: PlannedRun, finished: Record) -> dict[str, Any]:
    error = error_rpm(finished.run)  # type: ignore[arg-type]
    return {"speed_rpm": planned.speed_rpm, "load_nm": 1.0, "held": error < 1.0, "error_rpm": error}


def drive_points(_request: Any, _plan: Any, measured: Mapping[int, dict[str, Any]]) -> Any:
    for row in measured.values():
        speed = row["speed_rpm"]
        values = (1.0, 50.0, speed, 1.0, row["held"], speed, 1.0, 100.0, 5.0, 2.0)
        yield dict(zip(DRIVE_POINT, values, strict=True))


ERROR = Figure("error_rpm", "speed error", "rpm", 3)
COMPARISON = Comparison(
    kind="toy-comparison",
    plan=lambda request: tuple(
        PlannedRun("points", f"{speed:g} rpm", scenario_at(request.drive, speed), speed_rpm=speed)
        for speed in SPEEDS
    ),
    measure=figures,
    tables=(
        RunTable(
            name=POINTS,
            groups=("points",),
            rows=lambda planned, measured, best: [measured],
            columns=(name_of("candidate"), Figure("speed_rpm", "speed", "rpm", 0), HELD, ERROR),
        ),
    ),
    curves={},
    ranking=Ranking(
        rule="most points held, then the least error.",
        decides="error_rpm",
        place=("speed_rpm", "load_nm"),
        count="points",
        summaries={POINTS: {"error_mean_rpm": ("error_rpm", mean_of)}},
        columns=(Figure("error_mean_rpm", "mean error", "rpm", 3),),
        caption=lambda first: f"Errors next to those of {first}.",
        standing=lambda row: [],
    ),
    facts=lambda request, plan: {"drive": request.drive.identity(), "size": {}},
    supply_voltage_v=lambda drive: drive.inverter.supply_voltage_v,
    drive_points=drive_points,
    sections=(RANKING, Section(name="points", title="Points", table=POINTS)),
    method=lambda document: (),
    shown_facts=lambda document: (),
)


class Toy(Contract):
    """A voltage, as the controller of a DC motor sets it."""

    name = "toy"
    candidates = "toy candidates"
    usual_candidate = "toy:good"
    rehearsed = "toy:weak"
    witnesses = (Witness("toy:good", ("toy-motor",)),)
    checks = (CHECK,)
    families = ("speed",)
    simplifications = ()
    layout = Layout(
        "toy", SENSE, COMMAND, ToySense, lambda _: np.zeros(1, SENSE), lambda: np.zeros(1, COMMAND)
    )  # type: ignore[arg-type]
    sensed: ClassVar = {"reference": "rad/s", "speed": "rad/s", "phase_currents": "A"}
    outputs: ClassVar = {"voltage": ("voltage", "V")}
    plotted: ClassVar = {"voltage": ("V", 1.0)}
    recorded_names = ("time_s", "speed_rpm")
    summary_rows = ()
    window_columns = ()
    observations = ("speed_error_rpm",)

    def numbers(self, drive: Any, declaration: Any) -> dict[str, str]:
        return {"error": "1"}

    def fixed_scenarios(self, drive: Any, declaration: Any) -> tuple[Scenario, ...]:
        return tuple(scenario_at(drive, speed) for speed in SPEEDS)

    def drawn_scenarios(self, drive: Any, declaration: Any, group: Any) -> st.SearchStrategy[Scenario]:
        return st.integers(50, 500).map(lambda speed: scenario_at(drive, float(speed)))

    def unfair_because(self, scenario: Scenario) -> None:
        return None

    def drawn_range(self, scenario: Scenario) -> DrawnRange:
        return DrawnRange(*(Interval(0.0, 1e6),) * 4)

    def unseen(self, declaration: Any, scenario: Scenario) -> Record:
        return Record(scenario, Unseen(), declaration)

    def nameplate(self, scenario: Scenario, **_options: Any) -> dict[str, float]:
        constant = scenario.drive.machine.emf_constant_v_s_per_rad
        return {"emf_constant": constant, "control_period": scenario.control_period_s}

    def run(self, prepare: Any, scenario: Scenario, controller: Any, wrap: Any = None) -> ToyRun:
        controller.reset(self.nameplate(scenario))
        made: ToyRun = prepare(scenario, called(controller if wrap is None else wrap(controller)))
        return made

    def record(
        self, prepare: Any, declaration: Any, scenario: Scenario, controller: Any, **options: Any
    ) -> Record:
        made = self.run(prepare, scenario, controller)
        if options.get("kept") is not None:
            options["kept"][:] = made.commands
        return Record(scenario, made, declaration)

    def judged_window(self, check: Check, record: Record, margin: Any) -> tuple[float, float]:
        return 0.4, 0.5

    def step_seconds(self, controller: Any, record: Record) -> float:
        return 1e-6

    def given_steps(self, controller: Any, nameplate: dict[str, float]) -> Any:
        return ToySteps(controller, nameplate)

    def plant_state(
        self, prepare: Any, scenario: Scenario, commands: NDArray[Any], step: int
    ) -> dict[str, Any]:
        given = iter(commands)

        def play(_sense: Any, command: Any) -> None:
            command[0] = next(given)

        _, speed, current, _ = run_motor(scenario, play).trace[step]
        return {"speed_rpm": speed * RPM, "electrical_angle_deg": 0.0, "phase_currents": [current]}

    def signals(self, run: ToyRun) -> dict[str, NDArray[Any]]:
        names = ("time_s", "speed_rpm", "current_a", "voltage_v")
        return dict(zip(names, (run.trace * np.array([1.0, RPM, 1.0, 1.0])).T, strict=True))

    def account(self, trace: RecordedTrace) -> tuple[str, ...]:
        return (f"It ends at {trace.columns['speed_rpm'][-1]:.1f} rpm.",)

    def summary(self, record: Record) -> dict[str, Any]:
        return {"summary": {}, "windows": [], "clamped": ""}

    def observe(self, record: Record) -> dict[str, float]:
        return {"speed_error_rpm": error_rpm(record.run)}  # type: ignore[arg-type]

    def comparison(self) -> Comparison:
        return COMPARISON


class ToyAbility(Ability):
    """What the motor can do."""

    def run_time(self, drive: Any) -> RunTime:
        return RunTime(1.0, 10.0, "to reach its speed", 1.0)

    def reach(self, drive: Any) -> PowerReach:
        return PowerReach(np.ones(1), np.ones(1), np.ones(1))

    def constant_power(self, drive: Any) -> ConstantPower:
        return ConstantPower((1.0,), (1.0,), 1.0)

    def speeds(self, drive: Any) -> tuple[float, ...]:
        return SPEEDS

    def envelope(self, drive: Any, report: Any) -> dict[str, Any]:
        return {}

    def facts(self, envelope: dict[str, Any]) -> tuple[str, ...]:
        return ()

    def required(self, drive: Any) -> tuple[str, ...]:
        return ()


class ToyMotor(DriveKind):
    """A DC motor at a supply."""

    name = "toy-motor"
    contract = "toy"
    default_drive = str(DRIVE_FILE)
    compiling_s = 0
    has_angles = False

    def prepare_loop(self) -> Any:
        return run_motor


CONTRACTS["toy"] = Toy  # type: ignore[index]
DRIVE_KINDS["toy-motor"] = ToyMotor()  # type: ignore[index]
ABILITIES["toy-motor"] = ToyAbility()  # type: ignore[index]
KINDS["toy"] = KIND  # type: ignore[index]

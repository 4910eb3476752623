"""The contract of controllers that answer with duty ratios."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.contract import Contract, Later, Witness
from drivegate.contracts.duty.columns import (
    OBSERVATIONS,
    OUTPUTS,
    PANELS,
    PLOTTED,
    RECORDED_NAMES,
    SENSED,
    SUMMARY_ROWS,
    WINDOW_COLUMNS,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Record
    from drivegate.containment.messages import AnyController
    from drivegate.contracts.contract import RecordedTrace
    from drivegate.contracts.duty.record import DutyRecord
    from drivegate.contracts.duty.run import PrepareDutyLoop
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario


def _fixed_scenarios(drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
    from drivegate.contracts.duty.current_reference import STEPPED, is_current_in_reach, without_weakening
    from drivegate.contracts.duty.document import duty_document
    from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios

    document, reverses = duty_document(drive), declaration.reverses
    if declaration.follows_current:
        runs = fixed_scenarios(without_weakening(document), STEPPED, reverses=reverses)
        return tuple(run.replaced(drive=drive) for run in runs if is_current_in_reach(run))
    return fixed_scenarios(document, declaration.references, declaration.detects, reverses=reverses)


def _drawn_scenarios(
    drive: DriveDocument, declaration: Declaration, group: int | None
) -> SearchStrategy[Scenario]:
    from drivegate.contracts.duty.current_reference import STEPPED, is_current_in_reach, without_weakening
    from drivegate.contracts.duty.document import duty_document
    from drivegate.contracts.duty.scenarios.drawn.families import drawn_scenarios

    if declaration.follows_current:
        unweakened = without_weakening(duty_document(drive))
        runs = drawn_scenarios(unweakened, group, STEPPED, reverses=declaration.reverses)
        return runs.filter(is_current_in_reach).map(lambda run: run.replaced(drive=drive))
    return drawn_scenarios(
        duty_document(drive),
        group,
        declaration.references,
        declaration.detects,
        reverses=declaration.reverses,
    )


def _no_joint_scenarios(*_: object) -> tuple[Scenario, ...]:
    """Return none: what is varied jointly are sensors, disturbances and beginnings of the other contract."""
    return ()


def _no_joint_rows() -> int:
    return 0


def _record(
    prepare: PrepareDutyLoop,
    declaration: Declaration,
    scenario: Scenario,
    controller: AnyController,
    *,
    trace_every: int = 0,  # noqa: ARG001  (every run of this contract keeps its whole trace)
    kept: NDArray[Any] | None = None,
) -> DutyRecord:
    from drivegate.contracts.duty.plant_run import duty_run
    from drivegate.contracts.duty.record import DutyRecord
    from drivegate.contracts.duty.run import idle_bridge
    from drivegate.contracts.duty.scenarios.compared import mirror_image, with_other_dead_time

    run_once = partial(
        duty_run,
        prepare,
        controller=controller,
        idle=idle_bridge(declaration, scenario.control_period_s),
        follows_current=declaration.follows_current,
    )
    run = run_once(scenario)
    if kept is not None:
        kept[:] = run.commands
    other, mirror = (
        None if compared is None else DutyRecord(compared, run_once(compared), declaration)
        for compared in (with_other_dead_time(scenario), mirror_image(scenario))
    )
    return DutyRecord(scenario, run, declaration, other_dead_time=other, mirror=mirror)


def _account(trace: RecordedTrace) -> tuple[str, ...]:
    from drivegate.contracts.duty.words import duty_account, duty_signals

    return duty_account(duty_signals(trace))


def _nothing(_trace: RecordedTrace) -> None:
    """Return no mark and no common cause: there is no advance angle."""
    return


def _behaviour(
    run: Callable[[Scenario], Record], drive: DriveDocument, step: Scenario | None
) -> dict[str, Any]:
    from drivegate.contracts.duty.behaviour import behaviour
    from drivegate.contracts.duty.document import duty_document

    return behaviour(run, duty_document(drive), step)


_KINDS: Final = ("pm-ac",)

DUTY: Final = Contract(
    name="duty",
    candidates="duty-ratio candidates",
    default_drive="pm-ac-interior",
    usual_candidate="foc",
    witnesses=(
        Witness("foc", _KINDS),
        # These regulate otherwise, and detect failures as the first one does.
        *(Witness(name, _KINDS, silent_on=("SAF-1",)) for name in ("predictive-flux", "direct-torque")),
        # This is the first one but for the currents that it chooses.
        Witness("foc-loss-model", _KINDS, only_on=("EFF-1",)),
        # This detects no failure.
        Witness(
            "informed",
            _KINDS,
            knows_plant=True,
            made_for=Later("drivegate.contracts.duty.informed", "InformedController"),
            silent_on=("SAF-1",),
        ),
    ),
    checks=Later("drivegate.contracts.duty.checks.catalogue", "DUTY_CHECKS").value,
    families=(
        "torque step",
        "weakening",
        "speed step",
        "reversal",
        "load step",
        "low speed",
        "hoist",
        "start",
        "restart",
        "parameter",
        "supply step",
        "torque supply step",
        "sensor",
        "position error",
        "lost sample",
        "false edge",
        "joint change",
        "failure",
    ),
    numbers=Later("drivegate.contracts.duty.numbers", "numbers"),
    fixed_scenarios=_fixed_scenarios,
    drawn_scenarios=_drawn_scenarios,
    joint_scenarios=_no_joint_scenarios,
    joint_rows=_no_joint_rows,
    unfair_because=Later("drivegate.contracts.duty.scenarios.feasibility", "unfair_because"),
    simplifications=Later("drivegate.contracts.duty.scenarios.simplification", "DUTY_SIMPLIFICATIONS").value,
    drawn_range=Later("drivegate.contracts.duty.scenarios.drawn_range", "drawn_range"),
    unseen=Later("drivegate.contracts.duty.record", "unseen_duty_record"),
    record=_record,
    judged_window=Later("drivegate.contracts.duty.record", "judged_window"),
    step_seconds=Later("drivegate.contracts.duty.timed_steps", "duty_step_seconds"),
    layout=Later("drivegate_models.contract.layout", "DUTY").value,
    sensed=SENSED,
    outputs=OUTPUTS,
    plotted=PLOTTED,
    nameplate=Later("drivegate.contracts.duty.run", "duty_nameplate"),
    run=Later("drivegate.contracts.duty.plant_run", "duty_run"),
    given_steps=Later("drivegate.contracts.duty.timed_steps", "given_duty_steps"),
    plant_state=Later("drivegate.contracts.duty.plant_run", "plant_state"),
    signals=Later("drivegate.contracts.duty.figures", "signals"),
    recorded_signals=Later("drivegate.contracts.duty.figures", "signals"),
    recorded_names=RECORDED_NAMES,
    likely_causes=Later("drivegate.contracts.duty.likely_causes", "likely_causes_in_words"),
    panels=PANELS,
    account=_account,
    marked_angle=_nothing,
    common_cause=_nothing,
    summary=Later("drivegate.contracts.duty.figures", "summary"),
    summary_rows=SUMMARY_ROWS,
    window_columns=WINDOW_COLUMNS,
    observations=OBSERVATIONS,
    observe=Later("drivegate.contracts.duty.figures", "observe"),
    rehearsed="foc-mtpa",
    comparison=Later("drivegate.contracts.duty.comparison.declaration", "COMPARISON").value,
    behaviour=_behaviour,
)
"""Three duty ratios, as the firmware of a PM AC drive writes them to its timer."""

"""The contract of controllers that answer with duty ratios."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Record
from drivegate.containment.messages import AnyController
from drivegate.contracts.contract import Witness
from drivegate.contracts.drawings import Panel
from drivegate.contracts.duty.checks.catalogue import DUTY_CHECKS
from drivegate.contracts.duty.columns import OPTIONAL, DutyColumns
from drivegate.contracts.duty.current_reference import STEPPED, is_current_in_reach, without_weakening
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.figures import observe, signal, signals, summary
from drivegate.contracts.duty.informed import InformedController
from drivegate.contracts.duty.likely_causes import causes_of_check, likely_causes_in_words
from drivegate.contracts.duty.numbers import numbers
from drivegate.contracts.duty.plant_run import duty_run, plant_state
from drivegate.contracts.duty.record import DutyRecord, judged_window, unseen_duty_record
from drivegate.contracts.duty.run import PrepareDutyLoop, duty_nameplate, idle_bridge
from drivegate.contracts.duty.scenarios.compared import mirror_image, with_other_dead_time
from drivegate.contracts.duty.scenarios.drawn_range import drawn_range
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios, long_scenarios
from drivegate.contracts.duty.scenarios.simplification import DUTY_SIMPLIFICATIONS
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate.contracts.duty.sensed import empty_steps, sensed_signals
from drivegate.contracts.duty.timed_steps import duty_step_seconds, given_duty_steps
from drivegate.contracts.duty.words import account
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.contract.layout import DUTY as LAYOUT

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.contracts.comparison import Comparison

_KINDS: Final = ("pm-ac",)


class _DutyContract(DutyColumns):
    """Three duty ratios, as the firmware of a PM AC drive writes them to its timer."""

    name = "duty"
    candidates = "duty-ratio candidates"
    usual_candidate = "foc"
    rehearsed = "foc-mtpa"
    witnesses = (
        Witness("foc", _KINDS),
        # This has its own speed regulator and its own detector of failures.
        Witness("load-observer", _KINDS),
        # These regulate otherwise, and detect failures as the first one does.
        *(Witness(name, _KINDS, silent_on=("SAF-1",)) for name in ("predictive-flux", "direct-torque")),
        # This is the first one but for the currents that it chooses.
        Witness("foc-loss-model", _KINDS, only_on=("EFF-1",)),
        Witness("foc-sensorless", _KINDS, sensed=False),
        # This detects no failure.
        Witness("informed", _KINDS, knows_plant=True, made_for=InformedController, silent_on=("SAF-1",)),
    )
    checks = DUTY_CHECKS
    families = (
        "torque step",
        "weakening",
        "overspeed",
        "speed step",
        "reversal",
        "load step",
        "low speed",
        "hoist",
        "start",
        "restart",
        "released",
        "hot winding",
        "link",
        "parameter",
        "supply step",
        "torque supply step",
        "sensor",
        "position error",
        "lost sample",
        "false edge",
        "joint change",
        "failure",
        "sensorless start",
        "sensorless load",
        "sensorless load step",
        "sensorless reversal",
        "flying start",
        "lost rotor",
        "sensorless parameter",
    )
    simplifications = DUTY_SIMPLIFICATIONS
    layout = LAYOUT
    has_behaviour = True

    numbers = staticmethod(numbers)
    unfair_because = staticmethod(unfair_because)
    drawn_range = staticmethod(drawn_range)
    unseen = staticmethod(unseen_duty_record)
    judged_window = staticmethod(judged_window)
    step_seconds = staticmethod(duty_step_seconds)
    run = staticmethod(duty_run)
    given_steps = staticmethod(given_duty_steps)
    plant_state = staticmethod(plant_state)
    signals = staticmethod(signals)
    sensed_signals = staticmethod(sensed_signals)
    signal = staticmethod(signal)
    likely_causes = staticmethod(likely_causes_in_words)
    causes_of = staticmethod(causes_of_check)
    account = staticmethod(account)
    summary = staticmethod(summary)
    observe = staticmethod(observe)

    def settled_until(self, scenario: Scenario, /) -> tuple[float, ...]:
        return tuple(end for _, _, end in duty_windows(scenario))

    def signal_names_on(self, drive: DriveDocument, /) -> tuple[str, ...]:
        is_heated = duty_document(drive).thermal is not None
        return tuple(name for name in self.signal_names if is_heated or name not in OPTIONAL)

    def panels_of(self, scenario: Scenario, /) -> tuple[Panel, ...]:
        return self.panels if isinstance(scenario.load, DynamometerLoad) else self.panels_of_speed

    def fixed_scenarios(self, drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
        document, reverses = duty_document(drive), declaration.reverses
        if declaration.follows_current:
            runs = fixed_scenarios(without_weakening(document), STEPPED, reverses=reverses)
            return tuple(run.replaced(drive=drive) for run in runs if is_current_in_reach(run))
        return fixed_scenarios(document, declaration.references, declaration.detects, reverses=reverses)

    def long_scenarios(self, drive: DriveDocument, declaration: Declaration, /) -> tuple[Scenario, ...]:
        if declaration.follows_current:
            return ()
        return long_scenarios(duty_document(drive), declaration.references)

    def drawn_scenarios(
        self, drive: DriveDocument, declaration: Declaration, group: int | None
    ) -> SearchStrategy[Scenario]:
        from drivegate.contracts.duty.scenarios.drawn.families import drawn_scenarios

        document, reverses = duty_document(drive), declaration.reverses
        if declaration.follows_current:
            runs = drawn_scenarios(without_weakening(document), group, STEPPED, reverses=reverses)
            return runs.filter(is_current_in_reach).map(lambda run: run.replaced(drive=drive))
        return drawn_scenarios(
            document, group, declaration.references, declaration.detects, reverses=reverses
        )

    def record(
        self,
        prepare: PrepareDutyLoop,
        declaration: Declaration,
        scenario: Scenario,
        controller: AnyController,
        *,
        trace_every: int = 0,  # noqa: ARG002  (every run of this contract keeps its whole trace)
        kept: NDArray[Any] | None = None,
        keeps_steps: bool = False,
    ) -> DutyRecord:
        run_once = partial(
            duty_run,
            prepare,
            controller=controller,
            idle=idle_bridge(declaration, scenario.control_period_s),
            follows_current=declaration.follows_current,
        )
        steps = empty_steps(scenario) if keeps_steps else None
        run = run_once(scenario, steps=steps)
        if kept is not None:
            kept[:] = run.commands
        other, mirror = (
            None if compared is None else DutyRecord(compared, run_once(compared), declaration)
            for compared in (with_other_dead_time(scenario), mirror_image(scenario))
        )
        return DutyRecord(scenario, run, declaration, steps=steps, other_dead_time=other, mirror=mirror)

    def nameplate(self, scenario: Scenario, **options: Any) -> DutyNameplate:
        return duty_nameplate(scenario, **options)

    def comparison(self) -> Comparison:
        from drivegate.contracts.duty.comparison.declaration import COMPARISON

        return COMPARISON

    def behaviour(
        self, run: Callable[[Scenario], Record], drive: DriveDocument, step: Scenario | None
    ) -> dict[str, Any]:
        from drivegate.contracts.duty.behaviour import behaviour

        return behaviour(run, duty_document(drive), step)


DUTY: Final = _DutyContract()
"""The contract."""

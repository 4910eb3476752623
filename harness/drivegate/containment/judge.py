"""Doing jobs with one candidate: its code runs in a process of its own, everything that judges it runs here.

A candidate that is included with drivegate is drivegate's own code, and needs no other process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, Self, TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.candidates.kinds import KINDS, load_controller
from drivegate.containment.candidate_isolation import isolating_layers
from drivegate.containment.messages import AnyController, Job, JudgedCandidate, ResultT
from drivegate.containment.watches import SlowRun, WorkerLimits
from drivegate.isolation.layers import Layer

PayloadT = TypeVar("PayloadT")


def own_candidate(candidate: Candidate) -> JudgedCandidate:
    """Return a candidate that is included with drivegate as a job has it."""
    return JudgedCandidate(candidate, partial(load_controller, candidate))


class Judge:
    """Does jobs with one candidate, one after another; on Linux the candidate's process ends with this one.

    `on_slow` is called with the first run that will take long, while it runs. `layers` isolate the candidate's process;
    by default, those that the user requests.
    """

    def __init__(
        self,
        candidate: Candidate,
        *,
        limits: WorkerLimits | None = None,
        on_slow: Callable[[SlowRun], None] | None = None,
        layers: tuple[Layer, ...] | None = None,
    ) -> None:
        self._candidate = self._chosen = candidate
        self._layers = layers
        self._limits = limits
        self._on_slow = on_slow
        self._process: Any = None
        self._afresh = False
        self._kernels: dict[str, bytes] = {}
        self._is_isolated = True

    def run(self, job: Job[ResultT]) -> ResultT | Fault:
        """Do one job; one that hangs is tried once more."""
        ending: ResultT | Fault = self.once(job)
        if is_hang(ending):
            ending = self.once(job)
        return ending

    def once(self, job: Job[ResultT]) -> ResultT | Fault:
        self._afresh = job.afresh
        if job.afresh:
            self.kill()
        self._choose(self._candidate if not job.is_plain else replace(self._candidate, instrumented=None))
        try:
            return job.target(JudgedCandidate(self._chosen, self._new_controller), job.payload)
        except CandidateFault as ended:
            return ended.fault

    def _choose(self, candidate: Candidate) -> None:
        """Take a candidate with or without what looks into it; each has a process of its own."""
        if candidate != self._chosen:
            self.kill()
            self._chosen, self._process = candidate, None

    def _new_controller(self) -> AnyController:
        if KINDS[self._candidate.kind].is_included:
            return load_controller(self._candidate)
        from drivegate.containment.candidate_process import CandidateProcess
        from drivegate.containment.contained_controller import ContainedController
        from drivegate_models.compilation import kernels
        from drivegate_models.compilation.kernel_files import trust_only, trusts_all

        if self._process is None:
            KINDS[self._candidate.kind].compile_own_code(self._candidate)
            if trusts_all():
                self._kernels = kernels.kernel_digests()
                trust_only(self._kernels)
            layers = isolating_layers(self._candidate) if self._layers is None else self._layers
            self._is_isolated = bool(layers)
            self._process = CandidateProcess(self._chosen, self._limits, self._on_slow, layers or ())
        # Copies of one process share its addresses and hashes, which a repetition must not.
        self._process.starts_afresh = self._afresh
        return ContainedController(self._process)

    def kill(self) -> None:
        """End the candidate's process at once; the next instance starts another one."""
        if self._process is not None:
            self._process.kill()
            self._remove_changed_kernels()

    def close(self) -> None:
        """End the candidate's process, by itself within a moment."""
        if self._process is not None:
            self._process.close()
            self._remove_changed_kernels()

    def _remove_changed_kernels(self) -> None:
        """Remove the compiled kernels that a candidate may have changed, where nothing kept it from that.

        In a judge's process the harness does so, which knows what others have compiled meanwhile.
        """
        if self._kernels and not self._is_isolated:
            from drivegate_models.compilation.kernel_files import saved_digests
            from drivegate_models.compilation.kernels import remove_changed_kernels

            remove_changed_kernels([self._kernels, saved_digests()])

    def __enter__(self) -> Self:
        """Return the judge; the candidate's process starts with the first instance."""
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:
            self.kill()


def is_hang(ending: object) -> bool:
    return isinstance(ending, Fault) and ending.kind is FaultKind.HANG


def contained_runs(
    candidate: Candidate,
    target: Callable[[JudgedCandidate, PayloadT], ResultT],
    payloads: Iterable[PayloadT],
) -> Iterator[ResultT | Fault]:
    """Do something with a candidate many times, each time with a new instance, whatever becomes of the others.

    The candidate's process lives as long as the iteration, and no longer: what a candidate keeps for itself between
    runs depends on the payloads alone, never on how they are shared among processes.
    """
    refused: Fault | None = None
    with Judge(candidate) as judge:
        for payload in payloads:
            if refused is None:
                ending = judge.run(Job(target, payload))
                if isinstance(ending, Fault) and ending.phase == "loading":
                    refused = ending
                yield ending
            else:
                yield refused

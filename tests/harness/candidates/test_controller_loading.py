"""Every kind of candidate shows the same face to the closed loop."""

import pytest
from tests.harness import worker_jobs

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate_models.controllers.current.builtin import SEARCHES


def test_every_builtin_candidate_has_its_controller():
    assert set(BUILTIN_CANDIDATES) == set(SEARCHES)


@pytest.mark.parametrize("name", BUILTIN_CANDIDATES)
def test_a_builtin_runs_in_a_worker_and_its_instances_share_nothing(name):
    with Judge(resolve_candidate(name)) as worker:
        first, longer, again = (worker.run(Job(worker_jobs.drive, steps)) for steps in (50, 500, 50))
    assert first == again, "an earlier run shows in a later one"
    assert 0.0 < first < longer, (
        "with the speed below its reference, the reference of current must be positive"
    )


def test_a_python_class_is_loaded_too(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("class Mine:\n def reset(self, n): pass\n def step(self, s): pass\n", encoding="utf-8")
    assert isinstance(load_controller(resolve_candidate(f"{file}:Mine")), PythonController)

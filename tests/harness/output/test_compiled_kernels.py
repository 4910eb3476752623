"""What is said while kernels are compiled."""

import pytest

from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.output import waiting
from drivegate.output.waiting import with_compiled_kernels


@pytest.mark.parametrize("kinds", [("half-bridge",), ("star",), ("pm-ac",), ("half-bridge", "pm-ac")])
def test_the_time_to_compile_is_that_of_the_kind(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], kinds: tuple[str, ...]
) -> None:
    compiled: list[str] = []
    monkeypatch.setattr(waiting, "uncompiled_kinds", lambda _: kinds)
    monkeypatch.setattr(waiting, "compile_kernels", compiled.extend)
    with_compiled_kernels([])
    times = " and ".join(f"about {DRIVE_KINDS[kind].compiling_s} s for {kind} drives" for kind in kinds)
    assert capsys.readouterr().err.strip() == (
        f"compiling the kernels, which is done once and takes {times} on 2 processors"
    )
    assert compiled == list(kinds)


def test_every_kind_states_its_own_time() -> None:
    assert {name: kind.compiling_s for name, kind in DRIVE_KINDS.items()} == {
        "half-bridge": 20,
        "star": 20,
        "pm-ac": 25,
    }

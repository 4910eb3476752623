"""Other simulators of drives, where they are installed: simulated seconds a second, each on its own job."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

PEERS = sorted((Path(__file__).parent / "peers").glob("*.py"))


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.stem)
def test_peer(benchmark: Any, peer: Path) -> None:
    ended = benchmark.pedantic(
        subprocess.run,
        args=([sys.executable, str(peer)],),
        kwargs={"capture_output": True, "encoding": "utf-8", "check": True},
        rounds=1,
    )
    if not ended.stdout:
        pytest.skip(ended.stderr.strip())
    told = json.loads(ended.stdout)
    benchmark.extra_info["times_real_time"] = round(told["times_real_time"], 4)
    assert told["valid"], told["check"]

"""Controllers in C, most of which do one thing that a controller must not do."""

from collections.abc import Callable
from pathlib import Path

import pytest

HEADER = '#include "drivegate.h"\n#include <math.h>\n#include <stdlib.h>\n#include <string.h>\n'
VERSION = "int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }\n"
SIZE = "int64_t drivegate_state_size(void) { return sizeof(controller); }\n"
STATE = "typedef struct { double limit; int64_t steps; } controller;\n"
RESET = """int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
    controller *self = state;
    *self = (controller){.limit = nameplate->current_limit};
    %s
    return 0;
}
"""
STEP = """void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
    controller *self = state;
    self->steps += 1;
    command->current_reference = sense->speed < sense->speed_reference ? self->limit : 0.0;
    command->advance_angle = 0.0;
    if (self->steps == 5) { %s }
}
"""


def _source(
    *,
    top: str = "",
    reset: str = "",
    fifth_step: str = "",
    version: str = VERSION,
    size: str = SIZE,
) -> str:
    return HEADER + top + version + STATE + size + RESET % reset + STEP % fifth_step


@pytest.fixture
def controller_source() -> Callable[..., str]:
    """Write a controller that does something particular in its reset or in its fifth step."""
    return _source


@pytest.fixture
def written() -> Callable[..., Path]:
    """Write a source file into a folder."""

    def write(folder: Path, source: str, name: str = "mine.c") -> Path:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(source, encoding="utf-8")
        return file

    return write

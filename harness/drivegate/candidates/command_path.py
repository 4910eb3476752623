"""Where a candidate's own commands are found: those of `build`, and the program of the kind ``exec``."""

import os
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path


def command_path(environment: Mapping[str, str] = os.environ) -> str:
    """Return PATH of an environment, with the folder of drivegate's own Python in front if it lacks that `python3`.

    So `python3` has drivegate and its packages, also in a virtual environment that is not activated.
    """
    inherited = environment.get("PATH", os.defpath)
    own = Path(sys.executable).parent
    found = shutil.which("python3", path=inherited)
    if not (own / "python3").is_file() or (found is not None and Path(found).parent == own):
        return inherited
    return os.pathsep.join(filter(None, (str(own), inherited)))

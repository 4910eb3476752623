"""What CI servers and terminals obey in a job's log, read as they read it."""

import re

_LINE = re.compile(r"\r\n|[\r\n\v\f\x1c-\x1e\x85\u2028\u2029]")
_BRACKET = re.compile(r"##[A-Za-z]*\[")


def commands_in(log: str) -> list[str]:
    """List the lines that GitHub Actions, Azure Pipelines, TeamCity or a terminal would obey."""
    return [
        line
        for line in _LINE.split(log)
        if line.strip().startswith("::")
        or _BRACKET.search(line)
        or re.search(r"[\x00-\x08\x0e-\x1f\x7f-\x9f]", line)
    ]

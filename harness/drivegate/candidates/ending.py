"""How a process ended, in words."""

import signal


def ending_in_words(status: int) -> tuple[str, str]:
    """Tell how a process ended."""
    if status >= 0:
        return f"ended itself with exit status {status}", ""
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = f"signal {-status}"
    return f"was killed by {name} ({signal.strsignal(-status) or 'unknown'})", name

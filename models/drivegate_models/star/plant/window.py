"""Position of a phase in its conduction windows, which are split in halves if only one half chops.

The pieces of a cycle are numbered: 0 and 1 are the halves of the positive window, 2 is the gap after it, 3 and 4 are
the halves of the negative window, 5 is the gap after that. A window with equal halves is one piece, with the number of
its first half.
"""

from __future__ import annotations

from math import inf, pi
from typing import Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import wrapped

GAP: Final = 2
"""The piece after the positive window, in which the gates are off."""
PIECES: Final = 6
"""Number of pieces of a cycle; half a cycle has half of them."""


@inlined
def sector_of(piece: int) -> int:
    """Return the sign of the window that contains a piece, 0 for a gap."""
    if piece in (2, 5):
        return 0
    return 1 if piece < GAP else -1


@inlined
def chops(regulation: int, piece: int) -> bool:
    """Return True if a phase chops in a piece of a window."""
    return ((regulation >> (piece if piece < GAP else piece - 1)) & 1) != 0


@inlined
def _is_split(regulation: int, piece: int) -> bool:
    """Return True if only one half chops in the window that contains or precedes a piece."""
    halves = (regulation >> (0 if piece <= GAP else 2)) & 3
    return halves in (1, 2)


@inlined
def piece_at(angle: float, width: float, regulation: int, electrical: float) -> tuple[int, float]:
    """Return the piece at an angle at time zero, and the time of its end.

    - `angle`: electrical angle, advance included (rad).
    - `width`: width of each window (rad).
    - `regulation`: chopping halves, as in `StarDrive`.
    - `electrical`: electrical speed (rad/s); 0 at standstill.
    - Returns `piece`: number of the piece; `end`: end of the piece (s), infinite at standstill.
    """
    position = wrapped(angle - 0.5 * (pi - width))
    piece = 0
    if position >= pi:
        position -= pi
        piece = 3
    if position >= width:
        edge = pi
        piece += 2
    elif not _is_split(regulation, piece):
        edge = width
    elif position < 0.5 * width:
        edge = 0.5 * width
    else:
        edge = width
        piece += 1
    return piece, ((edge - position) / electrical if electrical > 0.0 else inf)


@inlined
def next_piece(piece: int, end: float, width: float, regulation: int, electrical: float) -> tuple[int, float]:
    """Return the piece after another one, and the time of its end.

    `piece`: number of the piece that ends. `end`: time of its end (s). `width`, `regulation`, `electrical`: arguments
    of `piece_at`, with a speed above 0. Returns `piece`: number of the next piece; `end`: end of the next piece (s).
    """
    following = (piece + 1) % PIECES
    if piece in (0, 3) and not _is_split(regulation, piece):
        following = piece + 2
    length = pi - width
    if sector_of(following) != 0:
        length = 0.5 * width if _is_split(regulation, following) else width
    return following, end + length / electrical

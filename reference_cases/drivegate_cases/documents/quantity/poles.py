"""The question of the number of poles, which has no unit: poles, pairs of poles, and slots next to them."""

from __future__ import annotations

import re
from typing import Final

from drivegate_cases.documents.quantity.question import Amount, Question
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

_WHOLE: Final = r"\d{1,6}(?:\.0+)?(?![.,]?\d)"
_COUNT: Final = r"(?:(?:number|no\.?|#|anzahl)\s*(?:of\s*)?)?(?:rotor\s*|stator\s*|magnet(?:ic)?\s*)?"
_PAIRS: Final = r"pole[\s-]*pairs?(?:\s*number)?|pairs?(?:\s*of\s*poles)?|polpaar\w*|p\.?p\.?"
_POLES: Final = r"poles?(?:\s*(?:count|number))?|polig|polzahl|magnets?"
_SLOTS: Final = r"slots?"
_STATED: Final = re.compile(
    rf"2p\s*[=:]\s*(?P<doubled>{_WHOLE})"
    rf"|(?P<before>{_WHOLE})[\s(-]*(?:{_COUNT}(?:(?P<pairs>{_PAIRS})|(?P<slots>{_SLOTS})|{_POLES})|(?P<few>[ns])|p)(?![a-z])"
    rf"|{_COUNT}(?:(?P<of_pairs>{_PAIRS})|(?P<of_slots>{_SLOTS})|{_POLES})(?![a-z])\s*(?:\(2?p\))?\s*[=:]?\s*"
    rf"(?P<after>{_WHOLE})"
    rf"|(?P<alone>{_WHOLE})"
)
_BETWEEN: Final = re.compile(r"[\s()/,;]*")


class PolesQuestion(Question):
    """The question of the number of poles."""

    def read(self, text: str) -> Amount:
        plain, quoted = text.strip().lower(), f"'{one_line(text)[:60]}'"
        found = [_poles(stated) for stated in _STATED.finditer(plain)]
        poles = sorted({number for number in found if number is not None})
        if not poles or not _BETWEEN.fullmatch(_STATED.sub("", plain)):
            raise self._not_understood(text)
        if len(poles) > 1:
            numbers = " and ".join(map(str, poles))
            raise InputError(f"{self.quantity}: {quoted} states {numbers} poles; accepted: {self.accepted}")
        if poles[0] == 0:
            raise InputError(f"{self.quantity}: {quoted} must be above 0")
        if poles[0] % 2:
            raise InputError(
                f"{self.quantity}: {quoted} makes no whole number of pole pairs; accepted: {self.accepted}"
            )
        return Amount(poles[0] / 2.0, one_line(text).strip(), "pairs of poles")


def _poles(stated: re.Match[str]) -> int | None:
    """Return the number of poles; none for one of slots."""
    if stated["slots"] or stated["few"] or stated["of_slots"]:
        return None
    number = int(float(stated["doubled"] or stated["before"] or stated["after"] or stated["alone"]))
    return 2 * number if stated["pairs"] or stated["of_pairs"] else number

"""The likely causes of failed checks: a table of faults of field-oriented control and of what each one shows.

The self-test's faults validate it: `python benchmarks/likely_causes.py` counts how often the seeded cause is named.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

from drivegate.contracts.duty.checks.accuracy import BRIDGE_OFF

MOST_NAMED: Final = 2
"""Causes that are named at most."""
_LEAST_AGREEMENT: Final = 0.3
"""Least agreement of failed checks with those of a cause that is named (1)."""


@dataclass(frozen=True)
class LikelyCause:
    """A cause, and the signs of it."""

    words: str
    signs: frozenset[str]
    """What fails: checks, each with what its measured value shows where that distinguishes causes."""
    confirmations: tuple[tuple[str, str], ...]
    """Signs that confirm it, the surest first, each with what its check shows then."""
    faults: tuple[str, ...]
    """Faulty controllers with this cause."""


def _cause(words: str, signs: str, confirmed_by: str, faults: str) -> LikelyCause:
    """Make a cause; `confirmed_by` lists checks, such as ``STA-1: the shaft does not start; SYM-1: it is uneven``."""
    pairs = (listed.partition(": ") for listed in confirmed_by.split("; "))
    return LikelyCause(
        words,
        frozenset(signs.split()),
        tuple((check, shows) for check, _, shows in pairs),
        tuple(faults.split()),
    )


LIKELY_CAUSES: Final = (
    _cause(
        "the order of the phases, the pole pairs or the sign of currents or angle is wrong",
        "ACC-1 ACC-1:torque DEC-1 EFF-1 FWK-1 FWK-3 FWK-3:braking OVC-1 OVC-2 ROB-4 ROB-4:error ROB-5 SAF-1 STA-1 "
        "STP-1 STP-1:late",
        "STA-1: the shaft does not start, or turns backward; ROB-4: the speed runs away from its reference",
        "wrong-pole-pairs swapped-phases reversed-currents swapped-hall-switches short-encoder-counter",
    ),
    _cause(
        "a current sensor has an offset",
        "ACC-1 EFF-1 FWK-1 OVC-2 RIP-4 ROB-4 ROB-5 STP-1",
        "RIP-4: the torque swings once a cycle",
        "current-sensor-offset small-current-offset offsets-under-current offsets-after-idling",
    ),
    _cause(
        "currents or torque are scaled wrong: by a sensor's gain, the magnet's flux, or core loss that is counted as a "
        "current",
        "ACC-1 ACC-1:torque EST-1 ROB-5 STP-1 STP-1:late",
        "ACC-1:torque: the torque is off in proportion to its reference; EST-1: the estimate of the torque is off too",
        "current-sensor-gain weak-magnets-assumed current-sensors-low swings-damped-one-way",
    ),
    _cause(
        "the angle of the shaft has an offset",
        "ACC-1 ACC-1:torque FWK-1 FWK-2 FWK-2:negative SYM-1",
        "SYM-1: a run backward is not the mirror image; FWK-2:negative: there is d current where none is best",
        "angle-offset start-angle-assumed phase-after-false-edges turns-summed-in-single-precision "
        "edges-summed-in-single-precision",
    ),
    _cause(
        "the inductances of d and q are swapped or taken for equal, or the d current has the wrong sign",
        "ACC-1 EFF-1 FWK-2 FWK-2:positive MTP-1 OVC-1 OVC-2 STP-1 STP-1:late",
        "MTP-1: the torque takes more than its least current; EFF-1: it costs more than its least loss",
        "saliency-ignored swapped-axes direct-inductance-doubled field-strengthened",
    ),
    _cause(
        "weakening stays on where the voltage is free",
        "ACC-1 EFF-1 FWK-2 FWK-2:negative MTP-1 OVC-2 STP-1 STP-1:late",
        "FWK-2:negative: there is d current at standstill; MTP-1: the torque takes more than its least current",
        "stuck-weakening strong-magnets-assumed weakening-kept-near-base",
    ),
    _cause(
        "the gains of the current regulator are too high, or its integral alone is: a zero makes the torque overshoot",
        "DEC-1 STP-1 STP-1:overshoot",
        "STP-1:overshoot: the torque overshoots; DEC-1: a step of the torque moves the d current",
        "nervous-currents eager-integrals",
    ),
    _cause(
        "the delay of a control period is not compensated, or by the wrong angle",
        "DEC-1 FWK-3 FWK-3:braking",
        "FWK-3:braking: braking at high speed lacks torque; DEC-1: a step of the torque moves the d current",
        "delay-turned-back delay-overcompensated late-samples one-way-prediction",
    ),
    _cause(
        "the current regulator is too slow, or its voltage is limited too early",
        "DEC-1 STP-1 STP-1:late",
        "STP-1:late: the torque rises late; DEC-1: a step of the torque moves the d current",
        "slow-currents clamped-phases",
    ),
    _cause(
        "the voltage of the link is measured late, as through a filter, or not at all",
        "STP-1 STP-1:link",
        "STP-1:link: the torque moves with the link",
        "link-filtered",
    ),
    _cause(
        "the speed or its regulator is wrong, in scale or integral part",
        "ACC-1 ACC-1:speed ROB-4 ROB-4:error ROB-5",
        "ROB-4:error: the speed is off after a step; ACC-1:speed: the speed is off in steady state",
        "speed-misread no-speed-integral slow-torque speed-clipped speed-taken-for-constant",
    ),
    _cause(
        "the speed regulator assumes another inertia",
        "ROB-4 ROB-4:overshoot",
        "ROB-4:overshoot: the speed overshoots after a step",
        "light-rotor-assumed heavy-rotor-assumed",
    ),
    _cause(
        "the controller limits voltage or current below what the drive has",
        "FWK-1 FWK-2 FWK-2:negative",
        "FWK-1: torque is missing above base speed; FWK-2:negative: there is more d current than the voltage needs",
        "supply-underestimated resistance-overestimated shallow-weakening shrunken-ratios shy-current-limit "
        "braking-reserve",
    ),
    _cause(
        "the current limit is taken too high",
        "FWK-3 FWK-3:current OVC-1 OVC-2",
        "OVC-2: the steady current exceeds the limit; OVC-1: its peaks do",
        "generous-current-limit lenient-current-limit",
    ),
    _cause(
        "commands are not limited to what the bridge can do",
        "DUT-1",
        "DUT-1: duty ratios or control period leave their range",
        "unclamped-ratios long-period",
    ),
    _cause(
        "the modulation is discontinuous, and the manifest does not declare it by the key 'modulation'",
        "RIP-4:clamped",
        "RIP-4:clamped: a leg is clamped to a rail nearly always",
        "",
    ),
    _cause(
        "dead time is not compensated, or too much",
        "DTM-1",
        "DTM-1: the torque swings at low speed with dead time, and not without",
        "dead-time-times-ten",
    ),
    _cause(
        "the estimate of the torque has a wrong factor, or lacks the reluctance torque",
        "EST-1",
        "EST-1: the estimate is off while the torque is right",
        "torque-of-rms-currents",
    ),
    _cause(
        "a failure is detected late, or not at all",
        "SAF-1",
        "SAF-1: the drive is not safe in time",
        "third-current-computed patient-stall-watch hall-edges-counted hall-edge-awaited jump-of-angle-believed "
        "jumps-of-angle-smoothed",
    ),
    _cause(
        "the bridge is off where nothing has failed: by a trip, or since the controller waits for 'enable' and the "
        "manifest does not state 'reads_enable'",
        "ACC-1 ACC-1:torque ACC-1:off ROB-4 ROB-5",
        "ACC-1:off: all legs are off, and the fault code names the trip",
        "undervoltage-at-once lost-currents-trip false-edges-trip swinging-speed-trips impatient-stall-watch "
        "sag-taken-for-short-circuit lift-taken-for-broken-coupling lowering-refused overvoltage-ends-braking",
    ),
    _cause(
        "the controller is not ready when the bridge turns on: its integrals and filters begin at 0 while the shaft "
        "turns, so preload them while 'enable' is 0, with 'reads_enable' in the manifest",
        "OVC-1 OVC-1:beginning",
        "OVC-1:beginning: the current peaks as the bridge turns on",
        "",
    ),
    _cause(
        "a reset leaves part of the state as it was",
        "DET-1",
        "DET-1: the same run differs the second time",
        "failure-survives-reset lost-samples-add-up",
    ),
    _cause(
        "the speed reaches the regulators late, through a filter or a difference over many steps",
        "DEC-1 ROB-4 ROB-4:overshoot",
        "ROB-4:overshoot: the speed overshoots after a step; DEC-1: a step of the torque moves the d current",
        "",
    ),
    _cause(
        "the output is frozen: duty ratios that no longer change while the shaft turns",
        "ACC-1 ACC-1:torque EFF-1 FWK-1 FWK-2 FWK-3 FWK-3:braking MTP-1 OVC-1 OVC-2 RIP-4 ROB-4 ROB-5 STA-1 STP-1 "
        "STP-1:late",
        "RIP-4: the torque swings with the angle, since the voltage does not turn with it",
        "",
    ),
    _cause(
        "a torque reference that is small loses its sign, or is taken for 0",
        "ACC-1 ACC-1:torque SYM-1",
        "SYM-1: a run backward is not the mirror image; ACC-1: only small torques are off",
        "",
    ),
    _cause(
        "a quotient by a reference of 0 is no number, which a conversion to an integer hides",
        "ACC-1 ACC-1:torque ACC-1:zero DEC-1 FWK-2 FWK-2:negative MTP-1 OVC-1 OVC-2 STP-1 STP-1:overshoot",
        "ACC-1:zero: the torque is off where its reference is 0",
        "",
    ),
    _cause(
        "part of the range of references is refused or limited",
        "ACC-1",
        "ACC-1: only some speeds or signs of torque are off",
        "weak-braking braking-cut-off slow-shaft-unseen idle-speed-forced backward-refused microseconds-signed "
        "braking-ends-at-highest-speed overspeed-taken-early torque-ramped-after-stall "
        "reference-clipped reference-missed-with-link reference-missed-with-sample",
    ),
    _cause(
        "braking charges the link, or loads its source, beyond what they bear: by a wrong limit or source of the link",
        "LNK-1 LNK-2 LNK-4",
        "LNK-1: the link exceeds its limit; LNK-2: the source takes back or supplies too much",
        "link-limit-overestimated rectifier-taken-for-battery link-taken-for-ideal charging-unlimited "
        "discharging-unlimited chopper-overestimated charging-limited-as-discharging braking-burnt-in-bursts",
    ),
    _cause(
        "the link is used for less braking than it bears: by a limit that is taken too low, or too high a gain",
        "LNK-3",
        "LNK-3: braking lacks torque that the link allows",
        "battery-charged-shyly link-regulated-nervously",
    ),
    _cause(
        "the windings get too hot: their temperature, or its limit, is wrong",
        "THM-1 THM-2",
        "THM-1: the windings exceed their limit; THM-2: their current does not fall there",
        "temperature-limit-raised temperature-read-low torque-alone-derated",
    ),
    _cause(
        "the torque is derated otherwise than hot windings require: too early, or at once",
        "THM-3",
        "THM-3: torque is missing, or jumps",
        "derated-while-cool derated-at-once torque-off-until-cool",
    ),
)
"""All of them."""
_SHOWN: Final = (
    ("STP-1", re.compile(r"overshoot"), "overshoot"),
    ("STP-1", re.compile(r".* to [\d.]+ %|[\d.]+ % is not"), "late"),
    ("STP-1", re.compile(r".* after the link steps"), "link"),
    ("ACC-1", re.compile(r"torque"), "torque"),
    ("ACC-1", re.compile(r"torque off by \S+ N·m from 0 N·m"), "zero"),
    ("ACC-1", re.compile(r"speed"), "speed"),
    ("FWK-3", re.compile(r"braking"), "braking"),
    ("FWK-3", re.compile(r"\S+ A "), "current"),
    ("RIP-4", re.compile(r".* a leg is clamped"), "clamped"),
    ("ROB-4", re.compile(r"speed overshoots"), "overshoot"),
    ("ROB-4", re.compile(r"speed off"), "error"),
    ("OVC-1", re.compile(r".* after the bridge turns on"), "beginning"),
)
_DIRECT: Final = re.compile(r"d current (\S+) A, (\S+) A is best")


def signs_of(checks: Iterable[Mapping[str, Any]]) -> frozenset[str]:
    return frozenset(sign for check in checks for sign in _signs(str(check["id"]), str(check["measured"])))


def _signs(check: str, measured: str) -> Iterator[str]:
    yield check
    for name, pattern, shown in _SHOWN:
        if name == check and pattern.match(measured):
            yield f"{check}:{shown}"
    if BRIDGE_OFF in measured:
        yield "ACC-1:off"
    found = _DIRECT.match(measured)
    if found is not None:
        # Against the magnet, or along it.
        yield f"{check}:{'negative' if float(found[1]) < float(found[2]) else 'positive'}"


@dataclass(frozen=True)
class Confirmation:
    """What another check than the failed ones that suggest a cause says of it."""

    kind: Literal["confirmed", "not run", "alone"]
    """Whether a further check confirms it, one that was not run would, or none but the failed one shows it."""
    check: str
    shows: str


def likely_causes(
    failed: Iterable[Mapping[str, Any]], met: Collection[str] = (), unjudged: Collection[str] | None = None
) -> tuple[tuple[LikelyCause, Confirmation], ...]:
    """Return the causes whose signs agree best with those of failed checks, the likeliest first.

    A cause whose confirming checks were all met is left out. Of causes that agree equally well, those that another
    failed check confirms come first.

    Parameters
    ----------
    failed : iterable of mappings
        Failed checks, each with ``id`` and ``measured``.
    met : collection of str
        Identifiers of checks that were judged and are met.
    unjudged : collection of str, optional
        Identifiers of checks that were not run but can be; by default all others.
    """
    shown = signs_of(failed)
    rated = []
    for cause in LIKELY_CAUSES:
        confirmation = _confirmation(cause, shown, met, unjudged)
        agreement = _agreement(cause.signs, shown)
        if confirmation is not None and agreement >= _LEAST_AGREEMENT:
            rated.append((agreement, confirmation.kind == "confirmed", cause, confirmation))
    rated.sort(key=lambda each: each[:2], reverse=True)
    return tuple((cause, confirmation) for _, _, cause, confirmation in rated[:MOST_NAMED])


def _confirmation(
    cause: LikelyCause, shown: frozenset[str], met: Collection[str], unjudged: Collection[str] | None
) -> Confirmation | None:
    """Find out what confirms a cause; a failed check does not confirm what it alone suggests."""
    evidence = {sign for sign in cause.signs & shown if ":" not in sign}
    named = [(sign, sign.partition(":")[0], shows) for sign, shows in cause.confirmations]
    for sign, check, shows in named:
        if sign in shown and evidence - {check}:
            return Confirmation("confirmed", check, shows)
    for _, check, shows in named:
        if check not in shown and check not in met and (unjudged is None or check in unjudged):
            return Confirmation("not run", check, shows)
    # The surest one speaks against the cause where it was judged and shows nothing of it.
    sign, check, shows = named[0]
    return Confirmation("alone", check, shows) if sign in shown else None


def likely_causes_in_words(
    failed: Iterable[Mapping[str, Any]],
    met: Collection[str],
    unjudged: Collection[str],
    command: Callable[[str], str],
) -> tuple[str, ...]:
    """Name the likely causes of failed checks, each with what confirms it; `command` runs a check by itself."""
    return tuple(
        f"{cause.words}; {_in_words(confirmation, command)}"
        for cause, confirmation in likely_causes(failed, met, unjudged)
    )


def _in_words(confirmation: Confirmation, command: Callable[[str], str]) -> str:
    check, shows = confirmation.check, confirmation.shows
    if confirmation.kind == "confirmed":
        return f"{check} fails too, which confirms it: {shows}"
    if confirmation.kind == "alone":
        return f"no other check confirms it; see in the run of {check} whether {shows}"
    return f"not confirmed yet; {command(check)} fails if so: {shows}"


def _agreement(signs: frozenset[str], shown: frozenset[str]) -> float:
    """Return the share of signs that two sets have in common (1)."""
    return 2.0 * len(signs & shown) / (len(signs) + len(shown)) if shown else 0.0


def causes_of_check(name: str) -> tuple[str, ...]:
    """List the causes that a check confirms, then those that it shows among other checks, the most specific first."""
    showing = [cause for cause in LIKELY_CAUSES if name in _checks(cause.signs) or name in _confirming(cause)]
    showing.sort(key=lambda cause: (name not in _confirming(cause), len(cause.signs)))
    return tuple(
        "; ".join(
            [
                cause.words,
                *(f"{sign.partition(':')[0]} confirms it: {shows}" for sign, shows in cause.confirmations),
            ]
        )
        for cause in showing
    )


def _confirming(cause: LikelyCause) -> frozenset[str]:
    return _checks(sign for sign, _ in cause.confirmations)


def _checks(signs: Iterable[str]) -> frozenset[str]:
    """Return the checks of signs, some of which state what a measured value shows too."""
    return frozenset(sign.partition(":")[0] for sign in signs)

"""A drive's numbers in the texts of checks of duty ratios, which name them."""

from __future__ import annotations

from drivegate.candidates.declaration import Declaration
from drivegate.checks.number_words import limit_words, milliseconds
from drivegate.contracts.duty.current_bandwidth import declared_rise_s, require_bandwidth, transient_periods
from drivegate.contracts.duty.current_reference import quadrature_for
from drivegate.contracts.duty.document import duty_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def numbers(drive: DriveDocument, declaration: Declaration) -> dict[str, str]:
    """Write the numbers that checks of duty ratios state, by the names that stand in their texts."""
    document, rating = duty_document(drive), drive.rating
    limits, bandwidth = limits_of(document), declaration.current_bandwidth
    if bandwidth is not None:
        require_bandwidth(document, bandwidth)
    safe, locked = (f"{1000.0 * time:.4g} ms" for time in (limits.safe_state_s, limits.safe_state_locked_s))
    return limit_words(drive) | {
        "base": f"{rating.base_speed_rpm:g} rpm",
        "current": f"{rating.current_limit_a:g} A",
        # The time with a locked rotor is stated where it is another one.
        "safe_time": safe if safe == locked else f"{safe} ({locked} with a locked rotor)",
        **_current_error(document, declaration),
        "rise": f"90 % within {milliseconds(limits.rise_time_s)}, plus the time that the voltage limit adds"
        if bandwidth is None
        else f"90 % of the currents within {1e3 * declared_rise_s(document, bandwidth):.4g} ms, by the declared "
        f"bandwidth of {bandwidth:g} rad/s, or within the least time that the voltage limit allows",
        "transient": f"{transient_periods(document, declaration)} control periods",
    }


def _current_error(drive: PmAcDocument, declaration: Declaration) -> dict[str, str]:
    """Write the error of a q current where a candidate gets one in place of a torque."""
    if not declaration.follows_current:
        return {}
    torque = drive.rating.rated_torque_nm
    error = quadrature_for(drive, torque) * limits_of(drive).torque_error_nm / torque
    return {"torque_error": f"{error:.4g} A of q current in its place"}

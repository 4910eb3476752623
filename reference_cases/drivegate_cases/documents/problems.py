"""Reporting everything that is wrong with a document in one sentence, from pydantic's list of errors."""

import re
from collections.abc import Callable, Iterator, Sequence
from types import UnionType
from typing import Any, Final, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from drivegate_cases.documents.wording import nearest_key, one_line, pointed, short_line, shortened, shown

Location = Sequence[int | str]

_LONGEST_KEY: Final = 100
_LONGEST_REST: Final = len("; and 1000000 more")


def described(error: ValidationError, model: type[BaseModel], longest: int = 240) -> str:
    """Report the errors of a document in so many characters, joined by semicolons; the last ones are only counted.

    Missing keys come last: their places are easy to find, and a misspelt key may be the reason.
    """
    errors = sorted(error.errors(include_url=False), key=lambda details: details["type"] == "missing")
    reported: list[str] = []
    remaining = longest
    for place, details in enumerate(errors):
        path = [step for step, _ in _walk(model, details["loc"])]
        part = _REPORTS.get(details["type"], _report_wrong_value)(details, path, model)
        if part in reported:
            continue
        least = 0 if place == len(errors) - 1 else _LONGEST_REST
        if reported and len(part) + least > remaining:
            reported.append(f"and {len(errors) - place} more")
            break
        reported.append(shortened(part, max(remaining - least, 0)))
        remaining -= len(part) + len("; ")
    return "; ".join(reported)


def key_name(path: Location) -> str:
    text = ""
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += f".{step}" if text else step
    return short_line(text, _LONGEST_KEY)


def _report_unknown(details: ErrorDetails, path: Location, model: type[BaseModel]) -> str:
    known = _sibling_keys(model, details["loc"])
    return f"the key '{key_name(path)}' is unknown, {nearest_key(str(path[-1]), known)}"


def _report_missing(details: ErrorDetails, path: Location, model: type[BaseModel]) -> str:
    if path and isinstance(path[-1], int):
        return f"the key '{key_name(path[:-1])}' has too few entries, {path[-1]}"
    description = _description(model, details["loc"])
    if not description:
        return f"the key '{key_name(path)}' is missing"
    article = "" if description.startswith("what ") else "the "
    return f"the key '{key_name(path)}' is missing, it gives {article}{description}"


def _report_excess(details: ErrorDetails, path: Location, _: type[BaseModel]) -> str:
    limits = details.get("ctx", {})
    return (
        f"the key '{key_name(path)}' has {limits.get('actual_length')} entries, "
        f"but must have at most {limits.get('max_length')}"
    )


def _report_rule(details: ErrorDetails, path: Location, _: type[BaseModel]) -> str:
    """Report what a rule of our own says; its message follows the key's value, or stands alone."""
    reason = one_line(str(details["ctx"]["error"]))
    if not path:
        return reason
    if reason.startswith("must "):
        return f"the key '{key_name(path)}' is {shown(details['input'])}, but {reason}"
    return f"in the key '{key_name(path)}', {reason}"


def _report_kind(details: ErrorDetails, path: Location, _: type[BaseModel]) -> str:
    context = details["ctx"]
    kinds = context.get("expected_tags")
    key = key_name([*path, context["discriminator"].strip("'")])
    if kinds is None:
        return f"the key '{key}' is missing, it says which kind of table this is"
    return f"the key '{key}' is {shown(context['tag'])}, but must be one of {kinds}"


def _report_wrong_value(details: ErrorDetails, path: Location, _: type[BaseModel]) -> str:
    requirement = _REQUIREMENTS.get(details["type"])
    if requirement is None:
        requirement = re.sub(r"^\w+ should", "must", one_line(details["msg"]))
    if details["type"] in ("float_type", "int_type") and isinstance(details["input"], str):
        requirement += pointed(details["input"])
    place = f"the key '{key_name(path)}'" if path else "the document"
    return f"{place} is {shown(details['input'])}, but {requirement}"


_REPORTS: dict[str, Callable[[ErrorDetails, Location, type[BaseModel]], str]] = {
    "extra_forbidden": _report_unknown,
    "missing": _report_missing,
    "too_long": _report_excess,
    "value_error": _report_rule,
    "union_tag_invalid": _report_kind,
    "union_tag_not_found": _report_kind,
}

_REQUIREMENTS = {
    "float_type": "must be a number",
    "int_type": "must be a whole number without a decimal point",
    "int_from_float": "must be a whole number",
    "string_type": "must be text in quotes",
    "string_unicode": "must be text that UTF-8 can hold",
    "bool_type": "must be true or false",
    "tuple_type": "must be a list",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "finite_number": "must be a finite number",
}


def _walk(model: type[BaseModel], location: Location) -> Iterator[tuple[int | str, Any]]:
    """Follow an error's location, leaving out the steps that only pick a member of a union."""
    annotation: Any = model
    for step in location:
        members = [member for member in _members(annotation) if _is_model(member)]
        chosen = [member for member in members if step in _kinds(member)]
        if len(members) > 1 and chosen:
            annotation = chosen[0]
            continue
        yield step, annotation
        annotation = _inside(annotation, members, step)


def _inside(annotation: Any, members: list[type[BaseModel]], step: int | str) -> Any:
    """Find the type of the value at a key or an index of a value of the given type."""
    field = _field_at(step, members)
    if field is not None:
        return field.annotation
    items = [item for member in _members(annotation) for item in get_args(member) if item is not Ellipsis]
    return items[-1] if items else None


def _field_at(step: int | str, members: list[type[BaseModel]]) -> FieldInfo | None:
    fields = (item for member in members for item in member.model_fields.items())
    return next((field for name, field in fields if step in (name, field.alias)), None)


def _members(annotation: Any) -> tuple[Any, ...]:
    """Take the members of a union, without its annotations, or the type itself."""
    if hasattr(annotation, "__metadata__"):
        return _members(annotation.__origin__)
    if get_origin(annotation) in (Union, UnionType):
        return tuple(member for part in get_args(annotation) for member in _members(part))
    return (annotation,)


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _kinds(model: type[BaseModel]) -> tuple[Any, ...]:
    """Take the values of a model's ``kind`` key, by which a union of models is distinguished."""
    kind = model.model_fields.get("kind")
    return get_args(kind.annotation) if kind and get_origin(kind.annotation) is Literal else ()


def _sibling_keys(model: type[BaseModel], location: Location) -> list[str]:
    """Take the keys that are known in the table where an error's last step stands."""
    _, annotation = list(_walk(model, location))[-1]
    models = [member for member in _members(annotation) if _is_model(member)]
    return [field.alias or name for member in models for name, field in member.model_fields.items()]


def _description(model: type[BaseModel], location: Location) -> str | None:
    """Take the description of the key that an error's last step names."""
    step, annotation = list(_walk(model, location))[-1]
    field = _field_at(step, [member for member in _members(annotation) if _is_model(member)])
    return None if field is None else field.description

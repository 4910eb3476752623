"""Debug information of an image (DWARF 2 to 5): names, types, and where fields are in them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, Final, NamedTuple

from drivegate_cases.documents.wording import short_line
from drivegate_models.errors import InputError

TYPES: Final = (
    "DW_TAG_typedef",
    "DW_TAG_structure_type",
    "DW_TAG_class_type",
    "DW_TAG_union_type",
    "DW_TAG_enumeration_type",
    "DW_TAG_base_type",
)
_NAMED: Final = ("DW_TAG_variable", "DW_TAG_subprogram", *TYPES)
_SCOPES: Final = ("DW_TAG_namespace", "DW_TAG_class_type", "DW_TAG_structure_type", "DW_TAG_union_type")
_TRANSPARENT: Final = (
    "DW_TAG_typedef",
    "DW_TAG_volatile_type",
    "DW_TAG_const_type",
    "DW_TAG_atomic_type",
    "DW_TAG_restrict_type",
)
REFERENCES: Final = ("DW_TAG_reference_type", "DW_TAG_rvalue_reference_type")
POINTERS: Final = ("DW_TAG_pointer_type", *REFERENCES)
_ORIGINS: Final = ("DW_AT_specification", "DW_AT_abstract_origin")
# Operations of expressions (DWARF 5, section 7.7.1).
_ADDRESS, _CONSTANT_UNSIGNED, _PLUS_CONSTANT = 0x03, 0x10, 0x23
POINTER_SIZE: Final = 4
"""Size of a pointer on these targets (bytes)."""

Length = int | None
"""Number of elements of an array; None where its type states none."""


class Typed(NamedTuple):
    """A type, without its names and qualifiers."""

    described: Any
    """As DWARF has it; of an array all of whose dimensions are left, the array."""
    lengths: tuple[Length, ...] = ()
    """Dimensions of an array that are left; `described` is the type of its elements where there are any."""


def described_in(information: Any) -> Iterator[tuple[str, Any]]:
    """List the variables, functions and types outside of functions, with their names.

    In C++ a name begins with those of its namespaces and class: ``control::Motor::count``.
    """
    units = list(information.iter_CUs())
    # Types that the compiler has put into units of their own.
    units += list(information.iter_TUs()) if hasattr(information, "iter_TUs") else []
    for unit in units:
        yield from _within(unit.get_top_DIE(), "")


def _within(outer: Any, scope: str) -> Iterator[tuple[str, Any]]:
    for die in outer.iter_children():
        if die.tag == "DW_TAG_namespace":
            yield from _within(die, f"{scope}{_prefix(die)}")
        elif die.tag in _NAMED:
            name = name_of(die)
            if name:
                yield f"{_scope_of_declared(die) or scope}{name}", die


def is_split(information: Any) -> bool:
    """Return True if the compiler has put names and types into files of their own (DWARF 5, section 7.3.2)."""
    named = ("DW_AT_dwo_name", "DW_AT_GNU_dwo_name")
    tops = (unit.get_top_DIE() for unit in information.iter_CUs())
    return any(name in top.attributes for top in tops for name in named)


def variable_in(function: Any, name: str) -> Any:
    """Return the variable of a name within a function; None where it has none."""
    for die in function.iter_children():
        if die.tag == "DW_TAG_variable" and name_of(die) == name:
            return die
        found = variable_in(die, name) if die.tag == "DW_TAG_lexical_block" else None
        if found is not None:
            return found
    return None


def _prefix(die: Any) -> str:
    """Return what a namespace or class adds to the names within; nothing where it has no name."""
    name = name_of(die)
    return f"{name}::" if name else ""


def _scope_of_declared(die: Any) -> str:
    """Return the namespaces and class in which what is completed here was declared."""
    if "DW_AT_specification" not in die.attributes:
        return ""
    scope, outer = "", referenced(die, "DW_AT_specification").get_parent()
    while outer is not None and outer.tag in _SCOPES:
        scope, outer = f"{_prefix(outer)}{scope}", outer.get_parent()
    return scope


def referenced(die: Any, attribute: str) -> Any:
    """Return what an attribute refers to."""
    stated = die.attributes[attribute]
    if stated.form == "DW_FORM_ref_sig8" and die.cu.header["version"] >= 5:
        return _types_by_signature(die.dwarfinfo)[stated.raw_value]
    return die.get_DIE_from_attribute(attribute)


@cache
def _types_by_signature(information: Any) -> dict[int, Any]:
    """Return the types in units of their own, which since DWARF 5 are among all other units."""
    return {
        unit.header["type_signature"]: unit.get_DIE_from_refaddr(unit.cu_offset + unit.header["type_offset"])
        for unit in information.iter_CUs()
        if "type_signature" in unit.header
    }


def name_of(die: Any) -> str:
    """Return the name of what is described; empty where it has none."""
    found = attribute_of(die, "DW_AT_name")
    return "" if found is None else str(found.value.decode(errors="replace"))


def attribute_of(die: Any, attribute: str) -> Any:
    """Return an attribute, or the one of the declaration that is completed; None where there is none."""
    if attribute in die.attributes:
        return die.attributes[attribute]
    for origin in _ORIGINS:
        if origin in die.attributes:
            return attribute_of(referenced(die, origin), attribute)
    return None


def type_of(die: Any, types: Mapping[str, Any]) -> Typed | None:
    """Return the type of what is described; None for that of a function that returns nothing, or ``void``."""
    while "DW_AT_type" not in die.attributes:
        origin = next((each for each in _ORIGINS if each in die.attributes), None)
        if origin is None:
            return None
        die = referenced(die, origin)
    return plain(referenced(die, "DW_AT_type"), types)


def plain(die: Any, types: Mapping[str, Any]) -> Typed | None:
    """Follow names and qualifiers of a type; None for ``void``."""
    while die.tag in _TRANSPARENT:
        if "DW_AT_type" not in die.attributes:
            return None
        die = referenced(die, "DW_AT_type")
    if die.tag == "DW_TAG_array_type":
        element = type_of(die, types)
        return None if element is None else Typed(element.described, (*_lengths(die), *element.lengths))
    if "DW_AT_signature" in die.attributes:
        die = referenced(die, "DW_AT_signature")
    if "DW_AT_declaration" in die.attributes:
        die = types.get(name_of(die), die)
    return Typed(die) if die.tag not in _TRANSPARENT else plain(die, types)


def _lengths(die: Any) -> tuple[Length, ...]:
    dimensions = [each for each in die.iter_children() if each.tag == "DW_TAG_subrange_type"]
    return tuple(_length(each.attributes) for each in dimensions)


def _length(dimension: Mapping[str, Any]) -> Length:
    count, last = (dimension.get(f"DW_AT_{name}") for name in ("count", "upper_bound"))
    if count is not None and isinstance(count.value, int):
        return count.value
    return last.value + 1 if last is not None and isinstance(last.value, int) else None


def size_of(typed: Typed | None) -> int:
    """Return the size of a type (bytes); 0 where its debug information states none."""
    if typed is None:
        return 0
    elements = 1
    for length in typed.lengths:
        elements *= length or 0
    die = typed.described
    if "DW_AT_byte_size" in die.attributes:
        return elements * int(die.attributes["DW_AT_byte_size"].value)
    return elements * (POINTER_SIZE if die.tag in POINTERS else 0)


def fields_of(typed: Typed, types: Mapping[str, Any]) -> dict[str, tuple[int, Any]]:
    """List the fields of a structure, those of anonymous ones within it and of base classes included.

    Each has its offset (bytes), and is as DWARF describes it.
    """
    found: dict[str, tuple[int, Any]] = {}
    for each in typed.described.iter_children():
        if each.tag not in ("DW_TAG_member", "DW_TAG_inheritance") or "DW_AT_declaration" in each.attributes:
            continue
        offset, name = _offset(each), name_of(each)
        if name:
            found.setdefault(name, (offset, each))
            continue
        within = type_of(each, types)
        if within is not None and not within.lengths:
            for inner, (further, die) in fields_of(within, types).items():
                found.setdefault(inner, (offset + further, die))
    return found


class Bits(NamedTuple):
    """Where a bit field is, in a target whose least significant bit is the first."""

    begin: int
    """Its first bit, from where the field begins that states it."""
    width: int


def bits_of(field: Any, types: Mapping[str, Any]) -> Bits | None:
    """Return the bits of a field; None for one of whole bytes."""
    stated = field.attributes
    if "DW_AT_bit_size" not in stated:
        return None
    width = int(stated["DW_AT_bit_size"].value)
    if "DW_AT_bit_offset" not in stated:
        return Bits(
            int(stated["DW_AT_data_bit_offset"].value) if "DW_AT_data_bit_offset" in stated else 0, width
        )
    # Until DWARF 4, from the most significant bit of a number in which the field is.
    whole = stated.get("DW_AT_byte_size")
    size = size_of(type_of(field, types)) if whole is None else int(whole.value)
    return Bits(8 * size - int(stated["DW_AT_bit_offset"].value) - width, width)


def _offset(die: Any) -> int:
    """Return where a field begins: a number, or in DWARF 2 an expression, which adds one to the address."""
    stated = die.attributes.get("DW_AT_data_member_location")
    if stated is None or isinstance(stated.value, int):
        return 0 if stated is None else int(stated.value)
    operation, *rest = stated.value
    if operation not in (_PLUS_CONSTANT, _CONSTANT_UNSIGNED):
        raise InputError(
            f"the place of the field '{short_line(name_of(die))}' is computed while the code runs; name another one"
        )
    return sum((byte & 0x7F) << (7 * place) for place, byte in enumerate(_number(rest)))


def _number(encoded: list[int]) -> Iterator[int]:
    """List the bytes of a number of variable length (LEB128)."""
    for byte in encoded:
        yield byte
        if not byte & 0x80:
            return


def address_of(die: Any) -> int | None:
    """Return the address that a variable has in the debug information; None where that states none."""
    stated = die.attributes.get("DW_AT_location")
    if stated is None or isinstance(stated.value, int) or list(stated.value[:1]) != [_ADDRESS]:
        return None
    return int.from_bytes(bytes(stated.value[1:5]), "little")


def parameters_of(die: Any) -> list[Any]:
    """List the parameters of a function in their order."""
    own = [each for each in die.iter_children() if each.tag == "DW_TAG_formal_parameter"]
    origin = next((each for each in _ORIGINS if each in die.attributes), None)
    return own if own or origin is None else parameters_of(referenced(die, origin))

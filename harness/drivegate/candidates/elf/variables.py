"""Where the variables of an image are and of what type, by its symbols and its debug information (DWARF)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, Final, NamedTuple

from elftools.common.exceptions import DWARFError, ELFError
from elftools.elf.elffile import ELFFile

from drivegate.candidates.elf.expression import Place
from drivegate.candidates.elf.image import attributes_of
from drivegate_cases.documents.wording import nearest, short_line, shown_path
from drivegate_models.errors import InputError

FLOAT, SIGNED, UNSIGNED = range(3)
"""Forms of a number."""

# Values of DW_AT_encoding (DWARF 5, section 7.8).
_FORMS: Final = {2: UNSIGNED, 4: FLOAT, 5: SIGNED, 6: SIGNED, 7: UNSIGNED, 8: UNSIGNED, 16: UNSIGNED}
_TRANSPARENT: Final = ("DW_TAG_typedef", "DW_TAG_volatile_type", "DW_TAG_const_type", "DW_TAG_atomic_type")
_TYPES: Final = ("DW_TAG_typedef", "DW_TAG_structure_type", "DW_TAG_union_type", "DW_TAG_base_type")


class Number(NamedTuple):
    address: int
    form: int
    size: int
    """Its size (bytes)."""


@dataclass(frozen=True)
class Variables:
    """What the debug information of an image states."""

    image: str
    """The image's file, as messages name it."""
    addresses: Mapping[str, tuple[int, ...]]
    """Addresses of variables by their names."""
    declared: Mapping[str, Any]
    """Variables by their names, as DWARF describes them."""
    types: Mapping[str, Any]
    functions: Mapping[str, Any]
    passes_floats_in_registers: bool
    """Whether functions return floating-point numbers in registers of the floating-point unit."""

    def number(self, place: Place) -> Number:
        """Find the number that a place is.

        Raises InputError if there is no such variable, or if it is no number.
        """
        if place.address is None:
            address, described = self._variable(place.root)
        else:
            address, described = place.address, _plain(self._known(self.types, place.root, "type"))
        for part in place.path:
            offset, described = self._part(described, part, place)
            address += offset
        form, size = self._form(described, place.text)
        return Number(address, form, size)

    def returned(self, function: str) -> tuple[int, int] | None:
        """Find form and size of what a function returns; None where it returns nothing."""
        described = self._known(self.functions, function, "function")
        if "DW_AT_type" not in described.attributes:
            return None
        return self._form(_plain(described.get_DIE_from_attribute("DW_AT_type")), function)

    def _variable(self, name: str) -> tuple[int, Any]:
        declared = self._known(self.declared, name, "variable")
        addresses = self.addresses.get(name, ())
        if len(addresses) != 1:
            count = "no variable" if not addresses else f"{len(addresses)} variables"
            raise InputError(f"{self.image} has {count} '{short_line(name)}' in memory; name a global one")
        return addresses[0], _plain(declared.get_DIE_from_attribute("DW_AT_type"))

    def _known(self, table: Mapping[str, Any], name: str, what: str) -> Any:
        if name in table:
            return table[name]
        if not table:
            raise InputError(f"{self.image} has no debug information; compile and link it with -g")
        raise InputError(
            f"{self.image} has no {what} '{short_line(name)}', the nearest one is '{nearest(name, list(table))}'"
        )

    def _part(self, described: Any, part: str | int, place: Place) -> tuple[int, Any]:
        """Find the offset of a field or an element, and its type."""
        if isinstance(part, int):
            if described.tag != "DW_TAG_array_type":
                raise InputError(f"'{place.text}' has an index, but what it is an element of is no array")
            count, inner = _length(described), _plain(described.get_DIE_from_attribute("DW_AT_type"))
            if part >= count:
                raise InputError(f"'{place.text}' is outside of its array, which has {count} elements")
            return part * _size(inner), inner
        if described.tag == "DW_TAG_pointer_type":
            raise InputError(f"'{place.text}' leads through a pointer; write what is there as Type(address)")
        fields = {
            each.attributes["DW_AT_name"].value.decode(): each
            for each in described.iter_children()
            if each.tag == "DW_TAG_member" and "DW_AT_name" in each.attributes
        }
        if part not in fields:
            known = f"; the nearest field is '{nearest(part, list(fields))}'" if fields else ""
            raise InputError(f"'{place.text}' has no field '{short_line(part)}'{known}")
        if "DW_AT_bit_size" in fields[part].attributes or "DW_AT_data_bit_offset" in fields[part].attributes:
            raise InputError(f"'{place.text}' is a bit field; name the whole register")
        offset = fields[part].attributes.get("DW_AT_data_member_location")
        return (0 if offset is None else int(offset.value)), _plain(
            fields[part].get_DIE_from_attribute("DW_AT_type")
        )

    def _form(self, described: Any, text: str) -> tuple[int, int]:
        if described.tag == "DW_TAG_enumeration_type":
            return SIGNED, _size(described)
        encoding = described.attributes.get("DW_AT_encoding")
        form = None if described.tag != "DW_TAG_base_type" or encoding is None else _FORMS.get(encoding.value)
        if form is None or _size(described) > 8:
            raise InputError(f"'{text}' is no number; name a field or an element of it that is one")
        return form, _size(described)


@cache
def variables_of(file: Path) -> Variables:
    try:
        # In memory, since types are read when they are needed.
        elf = ELFFile(BytesIO(file.read_bytes()))
        found: dict[str, dict[str, Any]] = {"DW_TAG_variable": {}, "DW_TAG_subprogram": {}, "type": {}}
        for die in _described(elf):
            kind = "type" if die.tag in _TYPES else die.tag
            name = die.attributes["DW_AT_name"].value.decode(errors="replace")
            # A structure that is declared only has no fields; a definition is behind it.
            if name not in found[kind] or "DW_AT_declaration" in found[kind][name].attributes:
                found[kind][name] = die
        return Variables(
            shown_path(file),
            _addresses(elf),
            found["DW_TAG_variable"],
            found["type"],
            found["DW_TAG_subprogram"],
            attributes_of(elf).get("TAG_ABI_VFP_ARGS") == 1,
        )
    except (DWARFError, ELFError, OSError, ValueError, KeyError, IndexError) as error:
        raise InputError(
            f"the debug information of {shown_path(file)} cannot be read: {short_line(str(error))}; link it again"
        ) from error


def _described(elf: Any) -> Iterator[Any]:
    """List the variables, functions and types that have a name, outside of functions."""
    if not elf.has_dwarf_info():
        return
    for unit in elf.get_dwarf_info().iter_CUs():
        for die in unit.get_top_DIE().iter_children():
            if (
                die.tag in ("DW_TAG_variable", "DW_TAG_subprogram", *_TYPES)
                and "DW_AT_name" in die.attributes
            ):
                yield die


def _addresses(elf: Any) -> dict[str, tuple[int, ...]]:
    table = elf.get_section_by_name(".symtab")
    found: dict[str, tuple[int, ...]] = {}
    for symbol in () if table is None else table.iter_symbols():
        if symbol["st_info"]["type"] == "STT_OBJECT" and symbol["st_shndx"] != "SHN_UNDEF":
            found[symbol.name] = (*found.get(symbol.name, ()), symbol["st_value"])
    return found


def _plain(die: Any) -> Any:
    """Follow names and qualifiers of a type."""
    while die.tag in _TRANSPARENT and "DW_AT_type" in die.attributes:
        die = die.get_DIE_from_attribute("DW_AT_type")
    return die


def _length(die: Any) -> int:
    """Return the number of elements of an array with one dimension."""
    dimensions = [each.attributes for each in die.iter_children() if each.tag == "DW_TAG_subrange_type"]
    if len(dimensions) != 1:
        raise InputError(
            "an array of several dimensions cannot be named; copy what is needed to a variable of its own"
        )
    count, last = (dimensions[0].get(f"DW_AT_{name}") for name in ("count", "upper_bound"))
    return int(count.value) if count is not None else 0 if last is None else int(last.value) + 1


def _size(die: Any) -> int:
    """Return the size of a type (bytes)."""
    if die.tag == "DW_TAG_array_type":
        return _length(die) * _size(_plain(die.get_DIE_from_attribute("DW_AT_type")))
    # Pointers may have no size of their own in DWARF; on these targets it is four bytes.
    return int(die.attributes["DW_AT_byte_size"].value) if "DW_AT_byte_size" in die.attributes else 4

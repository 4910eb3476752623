"""Where the variables of an image are and of what type, by its symbols and its debug information (DWARF)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, Final, NamedTuple

from elftools.common.exceptions import DWARFError, ELFError
from elftools.elf.elffile import ELFFile

from drivegate.candidates.elf.debug_information import (
    POINTERS,
    REFERENCES,
    TYPES,
    Typed,
    address_of,
    attribute_of,
    bits_of,
    described_in,
    fields_of,
    is_split,
    plain,
    size_of,
    type_of,
    variable_in,
)
from drivegate.candidates.elf.expression import Place
from drivegate.candidates.elf.image import attributes_of, source_name
from drivegate_cases.documents.wording import nearest, short_line, shown_path
from drivegate_models.errors import InputError

_LARGEST: Final = 8
"""Size of the largest number (bytes)."""
FLOAT, SIGNED, UNSIGNED = range(3)
"""Forms of a number."""

# Values of DW_AT_encoding (DWARF 5, section 7.8).
_FORMS: Final = {2: UNSIGNED, 4: FLOAT, 5: SIGNED, 6: SIGNED, 7: UNSIGNED, 8: UNSIGNED, 16: UNSIGNED}


class Number(NamedTuple):
    address: int
    """Where it is, or where the first pointer to it is."""
    form: int
    size: int
    """Its size (bytes)."""
    offsets: tuple[int, ...] = ()
    """What is added to each pointer on the way to it (bytes); none where no pointer is."""
    shift: int = 0
    """The first bit of a bit field in these bytes."""
    width: int = 0
    """Number of bits of a bit field; 0 for a number of whole bytes."""


class _Part(NamedTuple):
    """A field or an element of something larger."""

    offset: int
    """Where it begins (bytes)."""
    typed: Typed | None
    shift: int = 0
    width: int = 0
    """As in `Number`."""


@dataclass(frozen=True)
class Symbol:
    address: int
    size: int
    """Its size (bytes)."""


@dataclass(frozen=True)
class Variables:
    """What the debug information of an image states."""

    image: str
    """The image's file, as messages name it."""
    symbols: Mapping[str, tuple[Symbol, ...]]
    """Variables in memory by their names."""
    declared: Mapping[str, Any]
    """Variables by their names, as DWARF describes them."""
    scoped: Mapping[str, tuple[str, ...]]
    """Of names that stand for some with a namespace or class, these."""
    types: Mapping[str, Any]
    functions: Mapping[str, Any]
    is_split: bool
    """Whether its debug information is in files next to the objects."""
    passes_floats_in_registers: bool
    """Whether functions take and return floating-point numbers in registers of the floating-point unit."""

    def number(self, place: Place) -> Number:
        """Find the number that a place is.

        Raises InputError if there is no such variable, or if it is no number.
        """
        typed: Typed | None
        if place.address is None:
            address, typed = self._variable(place.root)
        else:
            address, typed = place.address, plain(self._known(self.types, place.root, "type"), self.types)
        return self.number_within(Number(address, 0, 0), typed, place)

    def number_within(self, begin: Number, typed: Typed | None, place: Place) -> Number:
        """Follow the fields and elements of a place from what begins at one, of a type."""
        address, offsets, part = begin.address, list(begin.offsets), _Part(0, typed)
        for named in place.path:
            typed = part.typed
            is_pointer = typed is not None and not typed.lengths and typed.described.tag in POINTERS
            if is_pointer:
                offsets.append(0)
                typed = self._pointed_to(typed, named, place)
            part = self._part(typed, named, place)
            if offsets:
                offsets[-1] += part.offset
            else:
                address += part.offset
        if part.typed is not None and not part.typed.lengths and part.typed.described.tag in REFERENCES:
            # As in C++, what it refers to is meant.
            offsets.append(0)
            part = _Part(0, type_of(part.typed.described, self.types))
        form, size = self._form(part.typed, place.text)
        if part.width:
            size = -(-(part.shift + part.width) // 8)
        if size > _LARGEST:
            raise InputError(
                f"the bit field '{place.text}' is in more than {_LARGEST} bytes; name another one"
            )
        return Number(address, form, size, tuple(offsets), part.shift, part.width)

    def returned(self, function: str) -> tuple[int, int] | None:
        """Find form and size of what a function returns; None where it returns nothing.

        One that was compiled without debug information, such as a library's, is taken to return an ``int``.
        """
        if self._described(function) not in self.functions and self.functions:
            return SIGNED, 4
        typed = type_of(self.function(function), self.types)
        return None if typed is None else self._form(typed, function)

    def function(self, name: str) -> Any:
        """Return a function as DWARF describes it."""
        name = self._described(name)
        if name not in self.functions and self.functions:
            raise InputError(
                f"{self.image} has no debug information of the function '{short_line(name)}', whose parameters [stub] "
                "names; compile it with -g"
            )
        return self._known(self.functions, name, "function")

    def _described(self, function: str) -> str:
        """Return the name by which a function is described: of a static one in C++ that in its source."""
        return function if function in self.functions else source_name(function) or function

    def _variable(self, name: str) -> tuple[int, Typed]:
        if len(self.scoped.get(name, ())) > 1:
            names = " and ".join(f"'{short_line(each)}'" for each in self.scoped[name][:3])
            raise InputError(
                f"{self.image} has several variables '{short_line(name)}': {names}; name one of them"
            )
        declared = self._declared(name)
        typed, symbols = type_of(declared, self.types), self.symbols.get(name, ())
        stated = address_of(declared)
        if typed is None:
            raise InputError(
                f"{self.image} states no type of the variable '{short_line(name)}'; compile its source with -g, not -g1"
            )
        if not symbols and stated is not None:
            return stated, typed
        if not symbols:
            raise InputError(
                f"{self.image} has no variable '{short_line(name)}' in memory: the compiler has made a constant of it, "
                "or left it out; declare it volatile, and link without -flto"
            )
        if len(symbols) != 1:
            raise InputError(
                f"{self.image} has {len(symbols)} variables '{short_line(name)}' in memory; name a global one that is "
                "linked"
            )
        if typed.lengths[:1] == (None,):
            # An array that is declared only has no length; its symbol has a size.
            element = size_of(typed._replace(lengths=typed.lengths[1:]))
            typed = typed._replace(lengths=(symbols[0].size // max(element, 1), *typed.lengths[1:]))
        return symbols[0].address, typed

    def _declared(self, name: str) -> Any:
        """Return a variable as DWARF describes it; a static one within a function is ``function::name``."""
        function, _, last = name.rpartition("::")
        if name not in self.declared and function in self.functions:
            found = variable_in(self.functions[function], last)
            if found is not None:
                return found
        return self._known(self.declared, name, "variable")

    def _known(self, table: Mapping[str, Any], name: str, what: str) -> Any:
        if name in table:
            return table[name]
        if not table:
            if self.is_split:
                raise InputError(
                    f"{self.image} has its debug information in other files; compile it without -gsplit-dwarf"
                )
            raise InputError(f"{self.image} has no debug information; compile and link it with -g")
        raise InputError(
            f"{self.image} has no {what} '{short_line(name)}', the nearest one is '{nearest(name, list(table))}'"
        )

    def _pointed_to(self, pointer: Typed | None, part: str | int, place: Place) -> Typed | None:
        """Return the type that a pointer points to, as an array where an element of it is named."""
        typed = None if pointer is None else type_of(pointer.described, self.types)
        if typed is None or not size_of(typed._replace(lengths=())):
            raise InputError(
                f"'{place.text}' leads through a pointer to a type without fields; write what is there as Type(address)"
            )
        return typed._replace(lengths=(None, *typed.lengths)) if isinstance(part, int) else typed

    def _part(self, typed: Typed | None, part: str | int, place: Place) -> _Part:
        if isinstance(part, int):
            if typed is None or not typed.lengths:
                raise InputError(f"'{place.text}' has an index, but what it is an element of is no array")
            count, inner = typed.lengths[0], typed._replace(lengths=typed.lengths[1:])
            if count is not None and part >= count:
                raise InputError(f"'{place.text}' is outside of its array, which has {count} elements")
            return _Part(part * size_of(inner), inner)
        fields = {} if typed is None or typed.lengths else fields_of(typed, self.types)
        if part not in fields:
            known = f"; the nearest field is '{nearest(part, list(fields))}'" if fields else ""
            raise InputError(f"'{place.text}' has no field '{short_line(part)}'{known}")
        offset, field = fields[part]
        kind, bits = type_of(field, self.types), bits_of(field, self.types)
        if bits is None or bits == (0, 8 * size_of(kind)):
            return _Part(offset, kind)
        return _Part(offset + bits.begin // 8, kind, bits.begin % 8, bits.width)

    def _form(self, typed: Typed | None, text: str) -> tuple[int, int]:
        size = size_of(typed)
        form = None
        if typed is not None and not typed.lengths:
            form = self._form_of_one(typed.described)
        if form is None or not 0 < size <= _LARGEST:
            raise InputError(f"'{text}' is no number; name a field or an element of it that is one")
        return form, size

    def _form_of_one(self, described: Any) -> int | None:
        if described.tag in POINTERS:
            return UNSIGNED
        if described.tag == "DW_TAG_enumeration_type":
            constants = (each.attributes.get("DW_AT_const_value") for each in described.iter_children())
            return SIGNED if any(each is not None and each.value < 0 for each in constants) else UNSIGNED
        encoding = described.attributes.get("DW_AT_encoding")
        is_number = described.tag == "DW_TAG_base_type" and encoding is not None
        return _FORMS.get(encoding.value) if is_number else None


@cache
def variables_of(file: Path) -> Variables:
    try:
        # In memory, since types are read when they are needed.
        elf = ELFFile(BytesIO(file.read_bytes()))
        found: dict[str, dict[str, Any]] = {"DW_TAG_variable": {}, "DW_TAG_subprogram": {}, "type": {}}
        information = elf.get_dwarf_info() if elf.has_dwarf_info() else None
        for name, die in () if information is None else described_in(information):
            known = found["type" if die.tag in TYPES else die.tag]
            for each in _names_of(name, die):
                # What is declared only has no fields and no length; a definition is behind it.
                if each not in known or _completes(die, known[each]):
                    known[each] = die
        scoped = {tag: _shortened(known) for tag, known in found.items()}
        return Variables(
            shown_path(file),
            _symbols(elf),
            found["DW_TAG_variable"],
            scoped["DW_TAG_variable"],
            found["type"],
            found["DW_TAG_subprogram"],
            information is not None and is_split(information),
            attributes_of(elf).get("TAG_ABI_VFP_ARGS") == 1,
        )
    except (DWARFError, ELFError, OSError, ValueError, KeyError, IndexError) as error:
        raise InputError(
            f"the debug information of {shown_path(file)} cannot be read: {short_line(str(error))}; link it again"
        ) from error


def _names_of(name: str, die: Any) -> tuple[str, ...]:
    """List the names of something: as the source has it, and as it is linked."""
    linked = [attribute_of(die, each) for each in ("DW_AT_linkage_name", "DW_AT_MIPS_linkage_name")]
    names = [each.value.decode(errors="replace") for each in linked if each is not None]
    return tuple(dict.fromkeys((name, *names)))


def _shortened(known: dict[str, Any]) -> dict[str, tuple[str, ...]]:
    """Let names with a scope be named without it, where nothing else has that name; return these with all they mean."""
    found: dict[str, tuple[str, ...]] = {}
    for name in known:
        last = name.rpartition("::")[2]
        if last not in known:
            found[last] = (*found.get(last, ()), name)
    known.update({last: known[names[0]] for last, names in found.items()})
    return found


def _completes(die: Any, known: Any) -> bool:
    return "DW_AT_declaration" in known.attributes and "DW_AT_declaration" not in die.attributes


def _symbols(elf: Any) -> dict[str, tuple[Symbol, ...]]:
    table = elf.get_section_by_name(".symtab")
    found: dict[str, tuple[Symbol, ...]] = {}
    for symbol in () if table is None else table.iter_symbols():
        if symbol["st_info"]["type"] == "STT_OBJECT" and symbol["st_shndx"] != "SHN_UNDEF":
            made = Symbol(symbol["st_value"], symbol["st_size"])
            found[symbol.name] = (*found.get(symbol.name, ()), made)
    return found

"""How the code of a function reaches its callers: as a copy inside them, or called by its symbol.

numba copies whatever a function calls into it, level by level, and optimises and translates every copy. Here a function
without a way in from Python or C is linked once, into each function that has machine code. One of `CALLED_FUNCTIONS` is
compiled once, and its callers call it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final
from weakref import WeakValueDictionary

from llvmlite import binding
from numba.core import cgutils, codegen

_COPIED: Final = "copied"
_DECLARATION: Final = re.compile(r'^declare .*@"(\w+)"\(.*$', re.MULTILINE)


CALLED_FUNCTIONS: Final[set[str]] = set()
"""Names of the functions that callers call by their symbols."""
INNER_FUNCTIONS: Final[set[str]] = set()
"""Names of the functions without a way in from Python or C."""


class CodeLibrary(codegen.JITCodeLibrary):
    """The code of one function, which becomes machine code only if something calls it.

    A function without a way in, which is not called by its symbol, is copied into each of its callers and optimised
    there. Machine code of its own would cost a quarter of the time of compilation, and nothing would run it.
    """

    _is_only_copied = False
    _declared: dict[str, str] | None = None
    _for_callers: Any = None

    def __init__(self, target_codegen: Any, name: str) -> None:
        super().__init__(target_codegen, name)
        # Libraries of the functions that this code calls by their symbols.
        self._called: list[CodeLibrary] = []

    def add_ir_module(self, ir_module: Any) -> None:
        """Add code, in which a function that is called by its symbol is declared with all that is known of it."""
        known: dict[str, str] = {}
        for each in _needed(self, set()):
            if each._is_called_by_symbol():
                known |= each._declarations()
        text = _DECLARATION.sub(lambda found: known.get(found[1], found[0]), str(ir_module))
        module = binding.parse_assembly(cgutils.normalize_ir_text(text))
        module.name = ir_module.name
        module.verify()
        self.add_llvm_module(module)

    def finalize(self) -> None:
        """Link what the function calls; optimise it and produce machine code unless it is only copied."""
        own = [each for each in self._final_module.functions if not each.is_declaration]
        has_way_in = any("cpython" in each.name or "cfunc" in each.name for each in own)
        is_inlined = any(b"alwaysinline" in attribute for each in own for attribute in each.attributes)
        is_inner = is_inlined or self.name in INNER_FUNCTIONS - CALLED_FUNCTIONS
        self._is_only_copied = is_inner and not has_way_in
        if self._is_only_copied:
            self._finalize_final_module()
            return
        needed = list(_needed(self, set()))
        self._called = [each for each in needed if each._is_called_by_symbol()]
        self._linking_libraries = [each for each in needed if not each._is_called_by_symbol()]
        super().finalize()

    def _optimize_final_module(self) -> None:
        """Link the functions that are still missing, and optimise the code as numba does."""
        self._link_missing()
        super()._optimize_final_module()

    def _link_missing(self) -> None:
        """Link again the libraries of functions that are declared here, but not yet defined.

        numba links each library once, in the order in which the source calls it. Of a library, LLVM adds only the
        functions that are declared by then. Where the optimiser has already removed the last call of a function, its
        library adds nothing, and another library that follows may still call it. numba's own libraries contain what
        they call, so only copied code is affected. Without this, the process ends with a segmentation fault, or
        numba with "Symbol ... not linked properly".

        To link callers before what they call would do as well, but it changes the order of the functions in every
        kernel, and with it what the optimiser inlines.
        """
        definitions = {
            function.name: library
            for library in self._linking_libraries
            for function in library._get_module_for_linking().functions
            if not function.is_declaration
        }
        while missing := [
            definitions[function.name]
            for function in self._final_module.functions
            if function.is_declaration and function.name in definitions
        ]:
            for library in dict.fromkeys(missing):
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)

    def _is_called_by_symbol(self) -> bool:
        """Return True if callers call the function by its symbol, rather than contain a copy of it."""
        return self.name in CALLED_FUNCTIONS and not self._is_only_copied

    def _declarations(self) -> dict[str, str]:
        """Return the declaration of each function by its name, with what the optimiser has found out about it.

        Without that, a caller assumes that the function writes all memory, and a loop takes up to 20 % more time.
        """
        if self._declared is None:
            self._declared = {
                function.name: _declaration(function)
                for function in self._get_module_for_linking().functions
                if not function.is_declaration and "cpython" not in function.name
            }
        return self._declared

    def serialize_using_object_code(self) -> Any:
        """Return what the cache keeps: the code, and that of all functions that it needs next to itself."""
        if self._is_only_copied:
            return self._code_for_callers()
        name, kind, data = super().serialize_using_object_code()
        return name, kind, data, [each._code_for_callers() for each in self._called]

    def _code_for_callers(self) -> Any:
        """Return what the cache keeps for callers: machine code only of a function that they call by its symbol."""
        if self._for_callers is None:
            if self._is_called_by_symbol():
                self._for_callers = self.serialize_using_object_code()
            else:
                others = self._linking_libraries if self._is_only_copied else self._called
                code = self._get_module_for_linking().as_bitcode()
                self._for_callers = self.name, _COPIED, code, [each._code_for_callers() for each in others]
        return self._for_callers

    @classmethod
    def _unserialize(cls, target_codegen: Any, state: Any) -> Any:
        name, kind, data, others = state
        code = data if kind == _COPIED else data[0]
        known = _loaded.get(code)
        if known is not None:
            return known
        needed = [cls._unserialize(target_codegen, each) for each in others]
        if kind == _COPIED:
            library: Any = target_codegen.create_library(name)
            library._is_only_copied = True
            library._final_module = library._shared_module = binding.parse_bitcode(data)
            library._linking_libraries = needed
            library._finalize_final_module()
        else:
            library = super()._unserialize(target_codegen, (name, kind, data))
            library._called = needed
        if kind == _COPIED or library._is_called_by_symbol():
            library._for_callers = state
        _loaded[code] = library
        return library

    def _finalize_final_module(self) -> None:
        if self._is_only_copied:
            self._finalize_dynamic_globals()
            self._finalized = True
        else:
            super()._finalize_final_module()


# The libraries that this process has loaded from the cache, by their code.
_loaded: WeakValueDictionary[bytes, CodeLibrary] = WeakValueDictionary()


def _needed(library: CodeLibrary, seen: set[CodeLibrary]) -> Iterator[CodeLibrary]:
    """Yield the libraries whose code a library needs, once each; a called one has what it needs itself."""
    for each in (*library._linking_libraries, *library._called):
        if each in seen:
            continue
        seen.add(each)
        yield each
        if each._is_only_copied:
            yield from _needed(each, seen)
        elif not each._is_called_by_symbol():
            yield from (called for called in each._called if called not in seen)
            seen.update(each._called)


def _declaration(function: Any) -> str:
    """Return the declaration of a function that is defined, with its attributes."""
    head = next(line for line in str(function).splitlines() if line.startswith("define "))
    signature = head.removeprefix("define ").removeprefix("linkonce_odr ").rpartition(") ")[0]
    return f"declare {signature}) {next(iter(function.attributes), b'').decode()}"


_set_known_environment = codegen.JITCPUCodegen.set_env
_magic_of_numba = codegen.JITCPUCodegen.magic_tuple


def _set_environment(self: Any, name: str, environment: Any) -> None:
    """Set a function's environment, which one that is only copied does not have."""
    if self._engine.is_symbol_defined(name):
        _set_known_environment(self, name, environment)


def _magic_tuple(self: Any) -> tuple[str, ...]:
    """Distinguish cached code of these libraries from numba's own, which a user's functions may have as well."""
    return (*_magic_of_numba(self), "code libraries of drivegate")


def keep_code_in_libraries() -> None:
    """Let numba keep code in the libraries of this module; it offers no other place to decide this."""
    codegen.JITCPUCodegen.set_env = _set_environment  # type: ignore[method-assign]
    codegen.JITCPUCodegen.magic_tuple = _magic_tuple  # type: ignore[method-assign]
    codegen.JITCPUCodegen._library_class = CodeLibrary

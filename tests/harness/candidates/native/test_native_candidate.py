"""A candidate in C or in a shared library: how it is named, compiled, kept, and refused."""

import logging
import os
import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from drivegate.candidates.candidate import NativeBuild
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.native.bounded_command import KEPT_OUTPUT, Bounds, run_bounded
from drivegate.candidates.native.build import FOLDER, built_library
from drivegate.candidates.native.compiler import C, Compilation, found_compiler, include_folder
from drivegate.candidates.resolution import resolve_candidate
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.compilation.cache_folder import CacheChoice
from drivegate_models.errors import InputError


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty folder to work in, and an empty cache."""
    monkeypatch.setenv("DRIVEGATE_CACHE", str(tmp_path / "cache"))
    for variable in ("CC", "CXX"):
        monkeypatch.delenv(variable, raising=False)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    return work


def libraries(folder):
    return sorted((folder.parent / "cache").glob(f"*/{FOLDER}/*.so"))


def manifest(folder, *lines, kind="c", entry="mine.c"):
    text = "\n".join(('schema = 1\nname = "my drive"', f'kind = "{kind}"', f'entry = "{entry}"', *lines))
    (folder / "candidate.toml").write_text(text, encoding="utf-8")
    return "candidate.toml"


def refusal(specification):
    with pytest.raises(InputError) as caught:
        resolve_candidate(specification)
    sentence = str(caught.value)
    assert sentence.isprintable(), "a refusal must fit on one line of a terminal"
    return sentence


def compiled_by_hand(source, target, *flags):
    command = ["cc", "-shared", "-fPIC", f"-I{include_folder()}", *flags, str(source), "-o", str(target)]
    subprocess.run(command, check=True)
    return target


def test_a_source_is_named_compiled_and_loaded(folder, written, controller_source):
    file = written(folder / "drives", controller_source())
    found = resolve_candidate("drives/mine.c")
    assert (found.name, found.kind, found.specification) == ("mine.c", "c", "drives/mine.c")
    assert (found.entry, found.folder, found.sources) == (str(file), file.parent, (file,))
    assert found.declaration == Declaration()
    assert isinstance(found.details, NativeBuild)
    assert [found.details.library] == libraries(folder)
    controller = load_controller(found)
    assert controller.step_address
    assert controller.state_address % 16 == 0


def test_a_library_is_named_and_loaded_from_its_place(folder, written, controller_source):
    library = compiled_by_hand(written(folder, controller_source()), folder / "mine.so")
    found = resolve_candidate("mine.so")
    assert (found.name, found.kind, found.sources) == ("mine.so", "so", (library,))
    assert found.details == NativeBuild(library)
    assert load_controller(found).state_address
    assert libraries(folder) == [], "what is compiled already needs no place in the cache"


def test_what_has_not_changed_is_not_compiled_again(folder, monkeypatch, written, controller_source):
    written(folder, controller_source())
    first = resolve_candidate("mine.c")
    built = libraries(folder)[0].stat().st_mtime_ns
    assert resolve_candidate("mine.c") == first
    assert libraries(folder)[0].stat().st_mtime_ns == built


@pytest.mark.one_in(2)
@pytest.mark.parametrize("change", ["source", "header", "flags", "further"])
def test_whatever_changes_is_compiled_again_and_changes_the_hash(folder, change, written, controller_source):
    written(folder, controller_source(top='#include "gains.h"\n'))
    written(folder / "headers", "#define GAIN 1\n", "gains.h")
    written(folder, "1\n", "table.csv")
    lines = ('include = ["headers"]', 'sources = ["table.csv"]')
    first = resolve_candidate(manifest(folder, *lines))
    assert {file.name for file in first.sources} == {"mine.c", "gains.h", "table.csv"}
    if change == "source":
        written(folder, controller_source(top='#include "gains.h"\n/* changed */\n'))
    elif change == "header":
        written(folder / "headers", "#define GAIN 2\n", "gains.h")
    elif change == "further":
        written(folder, "2\n", "table.csv")
    flags = ('flags = ["-O1"]',) if change == "flags" else ()
    second = resolve_candidate(manifest(folder, *lines, *flags))
    assert first.content_hash != second.content_hash
    assert first.details.library != second.details.library


def test_the_hash_does_not_depend_on_the_place(folder, written, controller_source):
    places = [written(folder / name, controller_source()) for name in ("one", "two")]
    hashes = {resolve_candidate(str(place)).content_hash for place in places}
    assert len(hashes) == 1


def test_a_manifest_compiles_several_sources(folder, written, controller_source):
    written(folder, controller_source(top="double limited(double);\n", fifth_step="limited(1.0);"))
    written(folder / "parts", "double limited(double value) { return value; }\n", "limited.c")
    found = resolve_candidate(manifest(folder, 'sources = ["parts/limited.c"]', "estimates_power = true"))
    assert (found.name, found.kind) == ("my drive", "c")
    assert [file.name for file in found.sources] == ["mine.c", "limited.c"]
    assert found.declaration == Declaration(estimates_power=True)
    load_controller(found)


IN_CPP = """#include "drivegate.h"
#include <memory>
#include <vector>

extern "C" double limited(double);

namespace {
class Controller {
public:
    explicit Controller(const drivegate_nameplate &nameplate) : limits_{nameplate.current_limit} {}
    double reference() const { return limited(0.5 * limits_.front()); }
private:
    std::vector<double> limits_;
};
std::unique_ptr<Controller> controller;
}

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return 0; }
int drivegate_reset(void *, const drivegate_nameplate *nameplate) {
    controller = std::make_unique<Controller>(*nameplate);
    return 0;
}
void drivegate_step(void *, const drivegate_sense *, drivegate_command *command) {
    command->current_reference = controller->reference();
    command->advance_angle = 0.0;
}
"""


@pytest.mark.needs("c++")
def test_sources_in_c_and_cpp_that_a_pattern_names(folder, written, caplog):
    written(folder, IN_CPP, "mine.cpp")
    written(folder / "src" / "parts", "double limited(double value) { return value; }\n", "limited.c")
    written(folder / "src", "#error not matched\n", "other.txt")
    lines = ('sources = ["src/**/*.c"]', 'flags = ["-std=c++20", "-std=c99"]')
    found = resolve_candidate(manifest(folder, *lines, entry="mine.cpp"))
    assert [file.name for file in found.sources] == ["mine.cpp", "limited.c"]
    assert caplog.records == [], "a standard of one language is for its own compiler"
    controller = load_controller(found)
    nameplate = load_drive("paper-5-phase").nameplate(1e-3)
    for _ in range(2):
        controller.reset(nameplate)
        assert controller.fault is None


@pytest.mark.needs("c++")
def test_a_source_in_cpp_is_a_candidate_by_itself(folder, written):
    alone = IN_CPP.replace('extern "C" double limited(double);', "#define limited(x) (x)")
    written(folder, alone, "mine.cpp")
    found = resolve_candidate("mine.cpp")
    assert (found.kind, found.contract) == ("c", "current")
    written(folder, alone.replace("std::vector<double> limits_;", "std::vector<double> limits;"), "mine.cpp")
    message = refusal("mine.cpp")
    assert message.startswith("mine.cpp, line 10: ")
    assert "the sources must compile with c++ -std=c++17" in message


@pytest.mark.parametrize(
    ("pattern", "sentence"),
    [
        ("src/**/*.c", "the pattern 'src/**/*.c' in 'sources' matches no file in "),
        ("../**/*.c", "the pattern '../**/*.c' in 'sources' leaves the manifest's folder"),
        ("/usr/**/*.c", "the pattern '/usr/**/*.c' in 'sources' leaves the manifest's folder"),
    ],
)
def test_a_pattern_that_names_no_sources_is_refused(folder, written, controller_source, pattern, sentence):
    written(folder, controller_source())
    assert sentence in refusal(manifest(folder, f'sources = ["{pattern}"]'))


def test_without_a_cpp_compiler_it_is_said_what_to_install(folder, monkeypatch, written):
    written(folder, IN_CPP, "mine.cpp")
    monkeypatch.setenv("PATH", str(folder))
    assert "there is no c++; install one (Debian and Ubuntu: apt install g++" in refusal("mine.cpp")
    monkeypatch.setenv("CXX", "absent-c++")
    assert "CXX names 'absent-c++', which is not there; install one" in refusal("mine.cpp")


def test_a_manifest_for_a_library(folder, written, controller_source):
    compiled_by_hand(written(folder, controller_source()), folder / "mine.so")
    found = resolve_candidate(manifest(folder, kind="so", entry="mine.so"))
    assert (found.name, found.kind) == ("my drive", "so")


@pytest.mark.parametrize(
    ("lines", "entry", "sentence"),
    [
        ([], "absent.c", "absent.c does not exist; name an existing file"),
        ([], "mine.txt", "the key 'entry' is 'mine.txt', but for the kind 'c' must be a file *.c"),
        (['include = ["absent"]'], "mine.c", "the key 'include' names 'absent', which is no folder"),
        (['flags = ["other.o"]'], "mine.c", "the key 'flags' has 'other.o', which is no flag"),
        (['flags = ["-o/tmp/x"]'], "mine.c", "the key 'flags' has '-o/tmp/x', but what the compiler writes"),
        (
            ['flags = ["-m32"]'],
            "mine.c",
            "the key 'flags' has '-m32', but a process of 64 bits loads no library of 32",
        ),
        (['flags = ["-fplugin=x.so"]'], "mine.c", "the key 'flags' has '-fplugin=x.so', but"),
        (['flags = ["@more"]'], "mine.c", "the key 'flags' has '@more', which is no flag"),
        (['flags = ["-fno-such-flag"]'], "mine.c", "-fno-such-flag"),
        (['sources = ["absent.c"]'], "mine.c", "absent.c does not exist"),
    ],
)
def test_a_manifest_that_cannot_be_built_is_reported(
    folder, lines, entry, sentence, written, controller_source
):
    written(folder, controller_source())
    written(folder, "", "mine.txt")
    assert sentence in refusal(manifest(folder, *lines, entry=entry))


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ("int x = y;\n", "mine.c, line 1: 'y' undeclared here (not in a function)"),
        ("int x = y;\nint z = w;\n", "(and 1 more error)"),
        ('#include "absent.h"\n', "mine.c, line 1: absent.h: No such file or directory"),
        ("#error \x1b[31mred\n", "mine.c, line 1: #error \\x1b[31mred"),
        ("int x = 1;\nint x = 2;\n", "mine.c, line 2: redefinition of 'x'"),
        (
            "",
            "mine.c does not export drivegate_abi_version, drivegate_state_size, drivegate_reset, drivegate_step",
        ),
    ],
)
def test_what_does_not_compile_or_link_is_reported_with_its_place(folder, source, sentence, written):
    written(folder, source)
    with pytest.raises(InputError) as caught:
        load_controller(resolve_candidate("mine.c"))
    message = str(caught.value)
    assert sentence in message
    assert message.isprintable()
    assert len(message) < 700


def test_all_functions_that_are_nowhere_are_reported_at_once(folder, written, controller_source):
    top = "void nowhere(void);\nextern int HAL_tick;\nvoid lost(int);\n"
    written(folder, controller_source(top=top, fifth_step="nowhere(); lost(HAL_tick); nowhere();"))
    with pytest.raises(
        InputError, match=r"mine\.c: nothing defines nowhere, HAL_tick, lost; add the sources"
    ):
        resolve_candidate("mine.c")


def test_the_whole_output_of_the_compiler_is_kept_in_a_file(folder, written):
    written(folder, "int x = y;\nint z = w;\n")
    sentence = refusal("mine.c")
    file = Path(sentence.rpartition(" is in ")[2])
    output = file.read_text(encoding="utf-8")
    assert output.count("error:") == 2
    assert libraries(folder) == []
    assert [path.name for path in file.parent.iterdir()] == [file.name], "something is left of the attempt"


def test_a_very_long_message_is_cut(folder, written):
    written(folder, f"#error {'x' * 100_000}\n")
    assert len(refusal("mine.c")) < 1000


def test_warnings_are_reported_once_when_it_compiles(folder, caplog, written, controller_source):
    written(folder, controller_source(fifth_step="int unused; int other;"))
    with caplog.at_level(logging.WARNING, logger="drivegate"):
        resolve_candidate("mine.c")
        resolve_candidate("mine.c")
    (record,) = caplog.records
    message = record.getMessage()
    assert message.startswith("mine.c, line ")
    assert "warning: unused variable '" in message
    assert "(and 1 more warning)" in message


def test_a_controller_that_warns_of_nothing_is_not_reported(folder, caplog, written, controller_source):
    written(folder, controller_source())
    resolve_candidate("mine.c")
    assert caplog.records == []


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("source", "bounds", "reason"),
    [
        ('#include "/dev/zero"\n', Bounds(20.0, memory_bytes=2**28), "out of memory"),
        ('#include "mine.c"\n#include "mine.c"\n', Bounds(0.5), "did not come to an end"),
        ("char x[1L << 40] = {1};\n", Bounds(20.0, file_bytes=2**20), "File size limit exceeded"),
    ],
)
def test_a_hostile_source_cannot_hold_up_or_fill_the_machine(folder, source, bounds, reason, written):
    written(folder, source)
    with pytest.raises(InputError, match=reason) as caught:
        built_library(Compilation(folder, ("mine.c",), bounds=bounds))
    assert bounds.in_words() in str(caught.value)


def test_a_tool_that_prints_without_end_is_stopped(folder):
    ended = run_bounded(["yes"], folder=folder, environment={}, bounds=Bounds(1.0))
    assert ended.status is None
    assert 0 < len(ended.output) <= 2 * KEPT_OUTPUT, "more is kept than the beginning and the end"


def has_gone(number):
    """Return True if a process has ended; whoever adopted it may not have reaped it yet."""
    with suppress(psutil.NoSuchProcess):
        psutil.Process(number).wait(5.0)
    return not psutil.pid_exists(number)


def test_a_tool_that_leaves_a_process_behind_is_not_waited_for(folder):
    command = ["sh", "-c", "sleep 30 & echo $!"]
    ended = run_bounded(command, folder=folder, environment={}, bounds=Bounds(1.0))
    assert has_gone(int(ended.output))


def test_a_tool_that_closes_its_output_and_leaves_a_process_is_reported_as_ended(folder):
    command = ["sh", "-c", "sleep 30 >/dev/null 2>&1 & echo $!"]
    ended = run_bounded(command, folder=folder, environment={}, bounds=Bounds(5.0))
    assert ended.status == 0
    assert has_gone(int(ended.output))


def test_without_a_compiler_it_is_said_what_to_install(folder, monkeypatch, written, controller_source):
    written(folder, controller_source())
    monkeypatch.setenv("PATH", str(folder))
    assert "there is no cc; install one (Debian and Ubuntu: apt install gcc" in refusal("mine.c")


@pytest.mark.parametrize(
    ("chosen", "sentence"),
    [
        ("absent-cc -O2", "CC names 'absent-cc', which is not there; install one"),
        ("'cc", "CC is ''cc', which is no command line"),
    ],
)
def test_a_compiler_that_is_not_there_is_reported(
    folder, monkeypatch, chosen, sentence, written, controller_source
):
    written(folder, controller_source())
    monkeypatch.setenv("CC", chosen)
    assert sentence in refusal("mine.c")


def test_the_compiler_of_the_environment_is_used(folder, monkeypatch, written, controller_source):
    written(folder, "#ifndef CHOSEN\n#error not chosen\n#endif\n" + controller_source())
    monkeypatch.setenv("CC", f"{shutil.which('cc')} -DCHOSEN")
    assert resolve_candidate("mine.c").kind == "c"


@pytest.fixture
def cached(folder, monkeypatch):
    """A compiler cache of which the folder on PATH has a link, as Debian's /usr/lib/ccache does."""
    links = folder / "links"
    links.mkdir()
    ccache = written_program(folder / "ccache", 'mkdir -p "${CCACHE_DIR-/proc/no}" || exit 3; exec cc "$@"')
    (links / "cc").symlink_to(ccache)
    monkeypatch.setenv("PATH", f"{links}:{os.environ['PATH']}")
    return ccache


def written_program(file, script):
    file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    file.chmod(0o755)
    return file


@pytest.mark.parametrize(
    "chosen", ["", "{folder}/links/cc -g", "{ccache} cc", "{ccache} debug=true {ccache} cc -g"]
)
def test_a_compiler_behind_a_cache_is_called_without_it(folder, monkeypatch, cached, chosen):
    monkeypatch.setenv("CC", chosen.format(folder=folder, ccache=cached))
    program, *flags = found_compiler(C)
    assert Path(program).resolve().name != "ccache"
    assert flags == (["-g"] if chosen.endswith("-g") else [])


def test_a_wrapper_that_is_a_script_compiles_with_a_cache_of_its_own(
    folder, monkeypatch, cached, written, controller_source
):
    script = written_program(folder / "my-cc", f'PATH=/usr/bin:/bin exec {cached} "$@"')
    written(folder, controller_source())
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("DRIVEGATE_READ", str(folder))
    assert resolve_candidate("mine.c").kind == "c"


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["-mine.c", "my drive$.c", "mine.C", "Größe.c"])
def test_a_source_may_have_any_name(folder, name, written, controller_source):
    written(folder, controller_source(), name)
    assert [file.name for file in resolve_candidate(f"./{name}").sources] == [name]


def test_without_a_folder_for_compiled_code_one_is_requested(folder, monkeypatch, written, controller_source):
    written(folder, controller_source())
    nothing = CacheChoice(None, ("/home/me/.cache/drivegate cannot be written (Permission denied)",))
    monkeypatch.setattr("drivegate_models.compilation.kernels.choose_folder", lambda _: nothing)
    said = refusal("mine.c")
    assert "/home/me/.cache/drivegate cannot be written (Permission denied)" in said
    assert "in the environment variable DRIVEGATE_CACHE" in said


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("echo 'error: no default toolchain is set' >&2; exit 1", "error: no default toolchain is set"),
        ("exit 3", "it printed nothing"),
    ],
)
def test_a_compiler_that_does_not_work_is_named_and_not_the_source(
    folder, monkeypatch, written, controller_source, script, reason
):
    written(folder, controller_source())
    broken = folder / "broken-cc"
    broken.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    said = refusal("mine.c")
    assert said.startswith(
        f"the C compiler '{broken}' does not work, it cannot compile a single line: {reason}"
    )
    assert "install one (Debian and Ubuntu: apt install gcc" in said


def test_the_include_folder_has_the_header():
    assert (include_folder() / "drivegate.h").is_file()

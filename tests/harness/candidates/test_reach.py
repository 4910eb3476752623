"""What a manifest may name: files in its own folder and in roots that the user names, whatever key names them."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from drivegate.candidates import candidate
from drivegate.candidates.candidate import hash_of
from drivegate.candidates.manifest import Manifest
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.candidate_isolation import own_places
from drivegate.isolation.installations import installation_of
from drivegate.isolation.layers import READ_VARIABLE, roots_named
from drivegate_cases.documents.regular_file import regular_content
from drivegate_models.errors import InputError

LIBRARY = b"\x7fELF" + bytes(100)


@dataclass(frozen=True)
class Key:
    """A way in which a manifest names a file or a folder."""

    lines: str
    """Its lines, with the file's or folder's path in braces."""
    target: str
    """Name of the file or folder."""


KEYS = {
    "python": Key('kind = "python"\nentry = "{}:Mine"', "mine.py"),
    # No other test has a module of this name, which might be imported already.
    "package": Key('kind = "python"\nentry = "{}:Mine"', "mine_apart"),
    "c": Key('kind = "c"\nentry = "{}"', "mine.c"),
    "so": Key('kind = "so"\nentry = "{}"', "mine.so"),
    "so that is built": Key('kind = "so"\nentry = "{}"\nsources = ["own.c"]\nbuild = ["true"]', "mine.so"),
    "elf": Key('kind = "elf"\nentry = "{}"', "mine.elf"),
    "fmu": Key('kind = "fmu"\nentry = "{}"', "mine.fmu"),
    "program": Key('kind = "exec"\nentry = "{}"', "tool"),
    "word": Key('kind = "exec"\nentry = "sh {}"', "mine.sh"),
    "second word": Key('kind = "exec"\nentry = "sh own.sh {}"', "table"),
    "sources": Key('kind = "exec"\nentry = "true"\nsources = ["{}"]', "id_rsa"),
    "sources of a build": Key('kind = "so"\nentry = "own.so"\nsources = ["{}"]\nbuild = ["true"]', "id_rsa"),
    "include": Key('kind = "c"\nentry = "own.c"\ninclude = ["{}"]', "headers"),
    "drive": Key('kind = "builtin"\nentry = "reference"\ndrive = "{}"', "mine.toml"),
    "requirements": Key('kind = "builtin"\nentry = "foc"\nrequirements = "{}"', "mine.toml"),
}
OF_FOLDERS = ("include", "package")
NO_PATHS = {
    "schema_version", "name", "kind", "build", "flags", "profile", "flowchart", "estimates_power", "power_window_s",
    "speed_range_rpm", "contract", "references", "detects", "reverses", "reads_enable", "calibration_time_s",
    "current_bandwidth_rad_s", "control_every", "update_delay", "modulation", "step_deadline_s", "start", "ram",
    "step_instructions", "step_cycles", "stack_bytes", "step", "peripherals", "write", "read", "once", "pause", "stub",
}  # fmt: skip
"""Keys that name nothing which drivegate opens: commands of a build and flags are for programs that are isolated.

The table `check` has tests of its own, with the command that reads it.
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    folder = tmp_path / "own"
    folder.mkdir()
    for name in ("own.c", "own.sh"):
        (folder / name).write_text("", encoding="utf-8")
    return folder


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """Return a folder of the user's next to the manifest's, with a file and a folder for each key."""
    folder = tmp_path / "outside"
    folder.mkdir()
    for key in KEYS.values():
        made(folder / key.target)
    return folder


def made(target: Path) -> None:
    if target.name in ("headers", "mine_apart"):
        target.mkdir(exist_ok=True)
        (target / "__init__.py").write_text("secret", encoding="utf-8")
    else:
        target.write_bytes(LIBRARY if target.suffix in (".so", ".elf") else b"secret")
        target.chmod(0o755)


@pytest.fixture(autouse=True)
def _at_once() -> Iterator[None]:
    """End a test that waits for what it has opened."""
    signal.alarm(20)
    yield
    signal.alarm(0)


def refusal(folder: Path, key: str, path: str) -> str:
    manifest = folder / "candidate.toml"
    if key == "program" and "/" not in path:
        path = f"./{path}"
    manifest.write_text(f'schema = 1\nname = "mine"\n{KEYS[key].lines.format(path)}\n', encoding="utf-8")
    with pytest.raises(InputError) as caught:
        resolve_candidate(str(manifest))
    assert "secret" not in str(caught.value)
    return str(caught.value)


def absolute(own: Path, target: Path) -> str:
    return str(target)


def by_dots(own: Path, target: Path) -> str:
    return f"../outside/{target.name}"


def by_a_link(own: Path, target: Path) -> str:
    (own / target.name).symlink_to(target)
    return target.name


def through_a_linked_folder(own: Path, target: Path) -> str:
    (own / "linked").symlink_to(target.parent)
    return f"linked/{target.name}"


def to_the_kernel(own: Path, target: Path) -> str:
    (own / target.name).symlink_to("/proc/kmsg")
    return target.name


WAYS = (absolute, by_dots, by_a_link, through_a_linked_folder, to_the_kernel)


def test_every_key_that_names_a_file_is_tried() -> None:
    assert set(Manifest.model_fields) == NO_PATHS | {
        "entry",
        "sources",
        "include",
        "drive",
        "requirements",
        "check",
    }


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("key", KEYS)
def test_nothing_outside_is_opened(
    key: str, way: Callable[[Path, Path], str], own: Path, outside: Path
) -> None:
    path = way(own, outside / KEYS[key].target)
    expected = "leads out of the manifest's folder"
    if key == "package":
        # A name with dots, which cannot lead out but by a link; the kernel has no packages.
        path = path.replace("../", "").replace("/", ".").strip(".")
        if way not in (by_a_link, through_a_linked_folder):
            expected = "names the module"
    assert expected in refusal(own, key, path)


@pytest.mark.parametrize("way", [absolute, by_dots, by_a_link, through_a_linked_folder])
def test_what_is_not_there_is_refused_in_the_same_words(
    way: Callable[[Path, Path], str], own: Path, outside: Path
) -> None:
    path = way(own, outside / "id_rsa")
    before = refusal(own, "sources", path)
    (outside / "id_rsa").unlink()
    assert refusal(own, "sources", path) == before


@pytest.mark.parametrize("pattern", ["linked/*", "linked/**/*", "*/id_rsa", "**/id_rsa", "id_*", "**"])
def test_no_pattern_leads_through_a_link(pattern: str, own: Path, outside: Path) -> None:
    (own / "linked").symlink_to(outside)
    (own / "id_rsa").symlink_to(outside / "id_rsa")
    assert "leads out of the manifest's folder" in refusal(own, "sources", pattern)


def test_links_that_lead_back_end_a_pattern_at_once(own: Path) -> None:
    for number in range(30):
        (own / f"again{number}").symlink_to(".")
    found = refusal(own, "sources", "/".join("*" * 30) + "/absent")
    assert "matches no file" in found


@pytest.mark.parametrize("key", [key for key in KEYS if key not in OF_FOLDERS and "word" not in key])
def test_a_fifo_keeps_nobody_waiting(key: str, own: Path) -> None:
    if "built" in key:
        # What is to be built need not be there.
        return
    os.mkfifo(own / KEYS[key].target, 0o755)
    found = refusal(own, key, KEYS[key].target)
    assert "not a regular file" in found or "does not exist" in found


def test_a_fifo_in_a_package_keeps_nobody_waiting(own: Path) -> None:
    made(own / "mine_apart")
    os.mkfifo(own / "mine_apart" / "other.py")
    assert "is not a regular file" in refusal(own, "package", "mine_apart")


@pytest.mark.parametrize("key", ["python", "c", "so", "fmu", "word", "second word", "sources", "drive"])
def test_a_huge_file_is_refused(key: str, own: Path) -> None:
    target = own / KEYS[key].target
    made(target)
    os.truncate(target, 2**40)
    found = refusal(own, key, target.name)
    assert "larger than" in found


def test_all_files_together_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "large"
    file.write_bytes(bytes(2**20))
    monkeypatch.setattr(candidate, "_LARGEST_BYTES", 4 * 2**20)
    hash_of([file] * 4, "")
    with pytest.raises(InputError, match="larger than 4 MiB together"):
        hash_of([file] * 5, "")


def test_files_of_the_kernel_are_read_as_far_as_their_size_says() -> None:
    with suppress(PermissionError):
        assert regular_content("/proc/kmsg") == b""
    assert regular_content("/proc/self/environ") == b""
    for device in ("/dev/zero", "/dev/tty"):
        with suppress(FileNotFoundError), pytest.raises(OSError, match="not a regular file"):
            regular_content(device)


def test_a_manifest_that_is_a_link_is_in_reach_itself(own: Path, outside: Path) -> None:
    (outside / "credentials").write_text('password = "secret"', encoding="utf-8")
    (own / "candidate.toml").symlink_to(outside / "credentials")
    with pytest.raises(InputError, match="leads out of the manifest's folder") as caught:
        resolve_candidate(str(own / "candidate.toml"))
    assert "password" not in str(caught.value)


@pytest.mark.parametrize("named", ["--root", READ_VARIABLE])
def test_a_root_that_the_user_names_is_in_reach(
    named: str, own: Path, outside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (own / "linked").symlink_to(outside)
    manifest = own / "candidate.toml"
    lines = f'entry = "true"\nsources = ["linked/id_*", "../outside/table", "{outside}/mine.c"]'
    manifest.write_text(f'schema = 1\nname = "mine"\nkind = "exec"\n{lines}\n', encoding="utf-8")
    if named == READ_VARIABLE:
        monkeypatch.setenv(READ_VARIABLE, str(outside))
        found = resolve_candidate(str(manifest))
    else:
        with roots_named([str(outside)]):
            found = resolve_candidate(str(manifest))
        assert READ_VARIABLE not in os.environ
    assert found.sources == tuple(outside / name for name in ("id_rsa", "table", "mine.c"))


def test_a_program_of_the_system_or_in_path_is_the_users(
    own: Path, outside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (own / "python").symlink_to(outside / "tool")
    found = refusal(own, "program", "./python")
    assert "leads out" in found
    monkeypatch.setenv("PATH", f"{outside}{os.pathsep}{os.environ['PATH']}")
    for entry in ("./python", "tool", "/bin/sh", "sh -c true", "python3 -c pass"):
        manifest = own / "candidate.toml"
        manifest.write_text(f'schema = 1\nname = "x"\nkind = "exec"\nentry = "{entry}"\n', encoding="utf-8")
        assert resolve_candidate(str(manifest)).kind == "exec"


def test_what_lies_next_to_a_program_is_not_opened_with_it(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A manifest in a folder named bin does not open the folder above, and a program in ~/bin not the home folder."""
    place = tmp_path / "project" / "bin"
    place.mkdir(parents=True)
    made(place / "tool")
    manifest = place / "candidate.toml"
    manifest.write_text('schema = 1\nname = "x"\nkind = "exec"\nentry = "./tool"\n', encoding="utf-8")
    opened = own_places(resolve_candidate(str(manifest)))
    assert all(Path(each).is_relative_to(place) for each in opened)
    monkeypatch.setenv("HOME", str(tmp_path))
    for folder, secret in ((tmp_path, ".ssh"), (tmp_path / ".cargo", "credentials.toml")):
        opened = installation_of(folder / "bin" / "tool")
        assert folder / "lib" in opened
        assert not any((folder / secret).is_relative_to(each) for each in opened)
    assert installation_of(tmp_path / "venv" / "bin" / "python") == [tmp_path / "venv"]
    assert installation_of(Path("/bin/sh")) == [Path("/bin/sh")]

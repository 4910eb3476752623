"""Compiled code is kept only where this user alone can write."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from drivegate_models.compilation import kernels
from drivegate_models.compilation.cache_folder import choose_folder
from drivegate_models.compilation.kernel_files import LISTED, list_digests
from drivegate_models.errors import InputError

KEY = "0123456789abcdef"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home folder and a folder for temporary files, and no variable that names another one."""
    for name in ("DRIVEGATE_CACHE", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    home, temporary = tmp_path / "home", tmp_path / "temporary"
    home.mkdir()
    temporary.mkdir()
    temporary.chmod(0o1777)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    return home


def in_home(home: Path) -> Path:
    return home / ".cache" / "drivegate" / KEY


def in_temporary(home: Path) -> Path:
    return home.parent / "temporary" / f"drivegate-{os.getuid()}" / KEY


def mode(folder: Path) -> int:
    return stat.S_IMODE(folder.stat().st_mode)


def test_the_folder_is_made_for_its_owner_alone(home: Path) -> None:
    former = os.umask(0)
    try:
        chosen = choose_folder(KEY)
    finally:
        os.umask(former)
    assert (chosen.folder, chosen.refusals) == (in_home(home), ())
    assert (mode(in_home(home)), mode(in_home(home).parent)) == (0o700, 0o700)


@pytest.mark.parametrize("variable", ["DRIVEGATE_CACHE", "NUMBA_CACHE_DIR"])
def test_a_folder_that_cannot_be_written_is_passed_over(
    home: Path, monkeypatch: pytest.MonkeyPatch, variable: str
) -> None:
    (home / "file").touch()
    monkeypatch.setenv(variable, str(home / "file" / "below"))
    chosen = choose_folder(KEY)
    assert chosen.folder == in_home(home)
    assert chosen.refusals == (f"{home / 'file' / 'below'} cannot be written (File exists)",)


def test_a_process_finds_the_folder_of_the_one_that_started_it(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(home / "chosen" / ("f" * 16)))
    assert choose_folder(KEY).folder == home / "chosen" / KEY
    monkeypatch.setenv("DRIVEGATE_CACHE", str(home / "own"))
    assert choose_folder(KEY).folder == home / "own" / KEY


@pytest.mark.parametrize("level", [0, 1], ids=["kernels", "their parent"])
@pytest.mark.parametrize("others", [0o770, 0o707], ids=["group", "everybody"])
def test_a_folder_that_others_can_write_is_not_trusted(
    home: Path, monkeypatch: pytest.MonkeyPatch, level: int, others: int
) -> None:
    monkeypatch.setenv("DRIVEGATE_CACHE", str(home / "shared"))
    (home / "shared" / KEY).mkdir(parents=True)
    (home / "shared", home / "shared" / KEY)[1 - level].chmod(others)
    chosen = choose_folder(KEY)
    assert chosen.folder == in_home(home)
    assert chosen.refusals == (f"{home / 'shared'} can be written by other users",)


def test_a_sticky_folder_may_contain_the_one_for_kernels(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DRIVEGATE_CACHE", tempfile.gettempdir())
    assert choose_folder(KEY).folder == Path(tempfile.gettempdir(), KEY)


def test_a_lax_umask_of_earlier_runs_is_put_right(home: Path) -> None:
    in_home(home).parent.mkdir(parents=True)
    in_home(home).parent.chmod(0o775)
    assert choose_folder(KEY).folder == in_home(home)
    assert mode(in_home(home).parent) == 0o700


@pytest.mark.parametrize("linked", [False, True], ids=["folder", "link"])
def test_what_another_user_has_made_is_not_trusted(
    home: Path, monkeypatch: pytest.MonkeyPatch, linked: bool
) -> None:
    monkeypatch.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("there is no home folder")))
    # Another user runs drivegate than the one who makes the folder.
    maker = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: maker + 1)
    monkeypatch.setattr("drivegate_models.compilation.cache_folder._ROOT", -1)
    planted = in_temporary(home).parent
    (planted.with_name("elsewhere") if linked else planted).mkdir(mode=0o700)
    if linked:
        planted.symlink_to("elsewhere")
    chosen = choose_folder(KEY)
    assert chosen.folder is None
    assert chosen.refusals == (f"{planted} belongs to another user",)
    with pytest.raises(InputError, match="belongs to another user; name a folder of your own") as refused:
        kernels.required_cache_folder()
    assert str(refused.value).endswith("in the environment variable DRIVEGATE_CACHE")


def test_what_root_has_compiled_for_all_users_is_copied(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    image = home / "image"
    monkeypatch.setenv("DRIVEGATE_CACHE", str(image))
    (image / KEY / "package").mkdir(parents=True, mode=0o755)
    (image / KEY / "package" / "kernel.nbi").write_text("code", encoding="utf-8")
    write = tempfile.TemporaryFile

    def refused_in_the_image(**place: Path) -> object:
        if place["dir"].is_relative_to(image):
            raise PermissionError(13, "Permission denied")
        return write(**place)

    monkeypatch.setattr(tempfile, "TemporaryFile", refused_in_the_image)
    for _ in range(2):
        assert choose_folder(KEY).folder == in_home(home)
    assert (in_home(home) / "package" / "kernel.nbi").read_text(encoding="utf-8") == "code"
    assert [path.name for path in in_home(home).parent.iterdir()] == [KEY]
    (image / KEY).chmod(0o777)
    (in_home(home) / "package" / "kernel.nbi").unlink()
    (in_home(home) / "package").rmdir()
    assert choose_folder(KEY).folder == in_home(home)
    assert list(in_home(home).iterdir()) == [], "others could have put it there"


def test_what_was_installed_with_drivegate_is_copied(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed = home / "site-packages"
    monkeypatch.setattr("drivegate_models.compilation.cache_folder.PACKAGED", installed)
    (installed / KEY).mkdir(parents=True)
    (installed / KEY / "kernel.nbi").write_text("code", encoding="utf-8")
    (installed / KEY).chmod(0o777)
    assert choose_folder(KEY).folder == in_home(home)
    assert list(in_home(home).iterdir()) == [], "others could have put it there"
    (installed / KEY).chmod(0o755)
    list_digests(installed / KEY)
    for _ in range(2):
        assert choose_folder(KEY).folder == in_home(home)
        assert (in_home(home) / "kernel.nbi").read_text(encoding="utf-8") == "code"


@pytest.mark.parametrize("listed", ["{}", "[]", "no list", '{"other.nbi": 1}', None])
def test_what_differs_from_the_list_of_its_wheel_is_not_copied(
    home: Path, monkeypatch: pytest.MonkeyPatch, listed: str | None
) -> None:
    installed = home / "site-packages"
    monkeypatch.setattr("drivegate_models.compilation.cache_folder.PACKAGED", installed)
    (installed / KEY).mkdir(parents=True)
    for name in ("same.nbi", "changed.nbc"):
        (installed / KEY / name).write_text("code", encoding="utf-8")
    list_digests(installed / KEY)
    (installed / KEY / "changed.nbc").write_text("other", encoding="utf-8")
    if listed is not None:
        (installed / KEY / LISTED).write_text(listed, encoding="utf-8")
    assert choose_folder(KEY).folder == in_home(home)
    copied = {path.name for path in in_home(home).glob("*.nb?")}
    assert copied == ({"same.nbi"} if listed is None else set())


def test_numba_uses_the_next_folder(home: Path) -> None:
    (home / "file").touch()
    command = "from drivegate_models.machine.winding_current import phi4; print(phi4._cache.cache_path)"
    done = subprocess.run(
        [sys.executable, "-c", command],
        env={**os.environ, "NUMBA_CACHE_DIR": str(home / "file")},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert Path(done.stdout.strip()).is_relative_to(home / ".cache" / "drivegate")

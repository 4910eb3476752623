"""Naming a candidate: every way to do it, and what is reported when nothing is found."""

import sys
from importlib.metadata import EntryPoint, EntryPoints

import pytest

from drivegate import __version__
from drivegate.candidates import resolution as candidate_resolution
from drivegate.candidates.builtin import resolution as builtin_resolution
from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.resolution import resolve_candidate
from drivegate_models.errors import InputError

SOURCE = "raise SystemExit('this module must not be imported by resolving it')\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(path, text=SOURCE):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", BUILTIN_CANDIDATES)
def test_a_bare_name_is_a_builtin(name):
    found = resolve_candidate(name)
    assert (found.name, found.kind, found.entry, found.sources) == (name, "builtin", name, ())
    assert found.declaration is BUILTIN_CANDIDATES[name]


def test_builtins_differ_in_their_hashes_by_name_and_version(monkeypatch):
    first = {resolve_candidate(name).content_hash for name in BUILTIN_CANDIDATES}
    monkeypatch.setattr(builtin_resolution, "__version__", __version__ + ".1")
    second = {resolve_candidate(name).content_hash for name in BUILTIN_CANDIDATES}
    assert len(first | second) == 2 * len(BUILTIN_CANDIDATES)


def test_a_file_and_its_class(folder):
    file = written(folder / "drives" / "mine.py")
    found = resolve_candidate("drives/mine.py:Mine")
    assert (found.name, found.kind, found.specification) == ("mine.py:Mine", "python", "drives/mine.py:Mine")
    assert (found.entry, found.folder, found.sources) == (f"{file}:Mine", file.parent, (file,))
    assert found.declaration == Declaration()


def test_the_hash_follows_content_and_class_but_not_the_place(folder):
    written(folder / "a" / "mine.py")
    written(folder / "b" / "mine.py")
    written(folder / "c" / "mine.py", SOURCE + "# changed\n")
    hashes = [
        resolve_candidate(text).content_hash
        for text in ("a/mine.py:Mine", "b/mine.py:Mine", "c/mine.py:Mine", "a/mine.py:Other")
    ]
    assert hashes[0] == hashes[1]
    assert len(set(hashes)) == 3


@pytest.mark.parametrize(
    ("module", "files"),
    [
        ("plain", ["plain.py"]),
        ("package", ["package/__init__.py", "package/inner.py"]),
        ("package.inner", ["package/inner.py"]),
        ("bare.deep.inner", ["bare/deep/inner.py"]),
    ],
)
def test_a_module_in_the_working_folder_is_found_without_importing_it(folder, module, files):
    for file in ("plain.py", "package/__init__.py", "package/inner.py", "bare/deep/inner.py"):
        written(folder / file)
    before = set(sys.modules)
    found = resolve_candidate(f"{module}:Mine")
    assert found.sources == tuple(folder / file for file in files)
    assert (found.name, found.entry, found.folder) == (f"{module}:Mine", f"{module}:Mine", folder)
    assert not {"plain", "package", "bare"} & (set(sys.modules) - before)


def test_an_installed_module_is_found_behind_a_folder_of_its_name(folder):
    (folder / "colorsys").mkdir()
    assert [file.name for file in resolve_candidate("colorsys:Mine").sources] == ["colorsys.py"]


def test_an_installed_entry_point(folder, monkeypatch):
    file = written(folder / "product.py")
    point = EntryPoint("product", "product:Controller", candidate_resolution.ENTRY_POINT_GROUP)
    monkeypatch.setattr(
        candidate_resolution, "entry_points", lambda group: EntryPoints([point]).select(group=group)
    )
    found = resolve_candidate("product")
    assert (found.name, found.entry, found.sources) == ("product", "product:Controller", (file,))
    with pytest.raises(InputError, match=r"'product'; known are .*initial, .*product"):
        resolve_candidate("produkt")


def test_a_manifest_for_python(folder):
    file, gains = written(folder / "drive" / "mine.py"), written(folder / "drive" / "gains.py", "")
    written(
        folder / "drive" / "candidate.toml",
        'schema = 1\nname = "my drive"\nkind = "python"\nentry = "mine.py:Mine"\nestimates_power = true\n'
        'sources = ["mine.py", "gains.py"]\n',
    )
    found = resolve_candidate("drive/candidate.toml")
    assert (found.name, found.kind, found.entry) == ("my drive", "python", f"{file}:Mine")
    assert (found.sources, found.folder) == ((file, gains), file.parent)
    assert found.declaration == Declaration(estimates_power=True)


def test_a_manifest_for_a_builtin(folder):
    written(folder / "candidate.toml", 'schema = 1\nname = "ours"\nkind = "builtin"\nentry = "reference"\n')
    found = resolve_candidate("candidate.toml")
    assert (found.name, found.kind, found.entry) == ("ours", "builtin", "reference")


@pytest.mark.parametrize(
    ("entry", "kind", "sentence"),
    [
        ("referense", "builtin", "reference, published, initial"),
        ("mine.py", "python", "must be module:Class or file.py:Class"),
        ("absent.py:Mine", "python", "absent.py does not exist"),
    ],
)
def test_a_manifest_that_leads_nowhere_is_reported(folder, entry, kind, sentence):
    written(folder / "candidate.toml", f'schema = 1\nname = "x"\nkind = "{kind}"\nentry = "{entry}"\n')
    with pytest.raises(InputError, match=sentence):
        resolve_candidate("candidate.toml")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "is empty, but must be module:Class, file.py:Class"),
        ("referense", "nearest known one is 'reference'; known are reference, published, initial"),
        ("absent.py:Mine", "absent.py does not exist; name an existing file"),
        ("place.py:Mine", "place.py is a folder; name an existing file"),
        ("absent.py", "names no class; write absent.py:Class"),
        ("absent.toml", "absent.toml does not exist"),
        (
            "absent.module:Mine",
            "names the module 'absent.module', which is neither installed nor in the folder",
        ),
        ("json.absent:Mine", "names the module 'json.absent'"),
        ("my-module:Mine", "names the module 'my-module', which is no name of a Python module"),
        (":Mine", "names the module '', which is no name of a Python module"),
        ("json:", "names the class '', which is no name of a Python class"),
        ("json:My Class", "names the class 'My Class', which is no name of a Python class"),
        ("json\0", "has a zero byte"),
        ("json\n:x", r"names the module 'json\\n'"),
    ],
)
def test_what_is_not_found_is_reported_in_one_sentence(folder, text, sentence):
    (folder / "place.py").mkdir()
    with pytest.raises(InputError, match=sentence) as caught:
        resolve_candidate(text)
    assert str(caught.value).isprintable(), "the sentence must fit on one line of a terminal"

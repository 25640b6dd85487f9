"""What lies in the cache is executed: only what this user has written there, and nobody has changed."""

from __future__ import annotations

import logging
import marshal
import os
import pickle
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from er_models.cache import folder as places
from er_models.cache import sealed
from er_models.cache.folder import cache_folder, state_folder
from er_models.cache.owned import demand_owned

NOBODY = 65534
PROGRAM = """
import sys
from er_models.cache.compiled import on_disk
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.kernel.load import kernel

@on_disk()
def twice(x):
    return 2.0 * x

few = Catalogue(tuple(CATALOGUE[n] for n in ("passive", "guo_yield", "response")))
print(twice(1.5), "damper" in vars(kernel(few)))
"""


class Planted:
    """What somebody else would like to be unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Callable[[str], None], tuple[str]]:
        return os.mkdir, (str(self.mark),)


@pytest.fixture(autouse=True)
def settled_anew() -> Iterator[None]:
    """Folders, keys and lines are found out once a process: each test begins without them."""
    found = (places._settled, places._made, places._private, places.tell, sealed._key)
    for each in found:
        each.cache_clear()
    yield
    for each in found:
        each.cache_clear()


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder."""
    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path))
    return cache_folder()


@pytest.fixture
def place(root: Path) -> Path:
    """A folder in it, with the sealed file `a`."""
    folder = state_folder("small-0")
    sealed.write(folder, "a", b"content")
    return folder


def run(folder: Path, **env: str) -> str:
    """What a program with compiled functions says to the user, in a process of its own that must end well."""
    (folder / "program.py").write_text(PROGRAM, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(folder / "program.py")], capture_output=True, text=True, check=True,
        env={"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PATH": os.environ["PATH"], **env},
    )  # fmt: skip
    assert done.stdout.split() == ["3.0", "True"]
    return done.stderr


@pytest.mark.slow
def test_nothing_that_was_planted_is_unpickled_or_executed(tmp_path: Path) -> None:
    """In the place of every file of a cache: made anew, and told in one line."""
    cache, mark = tmp_path / "cache", tmp_path / "mark"
    env = {"ER_CACHE_DIR": str(cache)}
    assert run(tmp_path, **env) == run(tmp_path, **env) == ""
    files = [p for p in cache.rglob("*") if p.suffix in (".compiled", ".code", ".py")]
    assert {path.suffix for path in files} == {".compiled", ".code", ".py"}
    code = marshal.dumps(compile(f"import os; os.mkdir({str(mark)!r})", "planted", "exec"))
    planted = {
        ".compiled": pickle.dumps(Planted(mark)),
        ".code": code,
        ".py": b"import os; os._exit(3)",
    }
    for path in files:
        before = path.read_bytes()
        path.write_bytes(before[: sealed.SEAL] * (path.suffix != ".py") + planted[path.suffix])
    lines = run(tmp_path, **env).splitlines()
    assert not mark.exists()
    assert len(lines) == 2
    assert "made anew: it is not as this user has written it" in lines[0] + lines[1]
    assert "it is not the source of this kernel, and is made anew" in lines[0] + lines[1]
    assert run(tmp_path, **env) == ""
    pickle.loads(planted[".compiled"])
    assert mark.exists(), "the plant would have been seen"


def test_a_sealed_file_is_read_again(place: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert sealed.read(place, "a") == b"content"
    sealed._key.cache_clear()  # another process
    assert sealed.read(place, "a") == b"content"
    assert sealed.read(place, "b") is None
    assert caplog.text == ""


def change(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)


def shorten(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: sealed.SEAL - 1])


def take(path: Path) -> None:
    """A file that was written to another place."""
    sealed.write(path.parent, "b", b"other")
    (path.parent / "b").replace(path)


def link(path: Path) -> None:
    path.rename(path.with_name("b"))
    path.symlink_to("b")


def pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def forge(path: Path) -> None:
    """Sealed with a key that others know."""
    key = path.parents[1] / "key"
    key.write_bytes(bytes(sealed.KEY))
    sealed._key.cache_clear()
    sealed.write(path.parent, path.name, b"forged")
    assert sealed.read(path.parent, path.name) == b"forged"
    key.chmod(0o644)
    sealed._key.cache_clear()


TAMPERED: dict[str, tuple[Callable[[Path], None], str]] = {
    "changed": (change, "it is not as this user has written it"),
    "cut short": (shorten, "it is not as this user has written it"),
    "of another place": (take, "it is not as this user has written it"),
    "key that others read": (forge, "it is not as this user has written it"),
    "a link": (link, "Too many levels of symbolic links"),
    "no file": (pipe, "it is no ordinary file"),
    "written by a group": (lambda path: path.chmod(0o660), "others may write to it"),
    "written by all": (lambda path: path.chmod(0o606), "others may write to it"),
    "in an open folder": (lambda path: path.parent.chmod(0o770), "others may write to it"),
    "in an open cache": (lambda path: path.parents[1].chmod(0o777), "others may write to it"),
}


@pytest.mark.parametrize("way", TAMPERED)
def test_a_file_that_somebody_else_could_have_made_is_not_read(
    way: str, place: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """One line; written anew it is read again, where the folders are this user's alone."""
    tamper, reason = TAMPERED[way]
    tamper(place / "a")
    assert sealed.read(place, "a") is None
    assert sealed.read(place, "a") is None
    assert caplog.messages == [f"{place}: a file is not used, and made anew: {reason}"]
    place.parent.chmod(0o700)
    sealed.write(place, "a", b"anew")
    assert sealed.read(place, "a") == b"anew"
    assert stat.S_IMODE((place / "a").lstat().st_mode) == 0o600


def test_owners(tmp_path: Path) -> None:
    """This user and root, and who is named beside them."""
    found = list(tmp_path.stat())
    for owner in (os.geteuid(), 0):
        found[stat.ST_UID] = owner
        demand_owned(os.stat_result(found))
    found[stat.ST_UID] = NOBODY
    demand_owned(os.stat_result(found), also=(NOBODY,))
    with pytest.raises(PermissionError, match="belongs to another user"):
        demand_owned(os.stat_result(found))


def test_everything_in_the_cache_is_for_this_user_alone(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        run(tmp_path, ER_CACHE_DIR=str(tmp_path / "cache"))
    finally:
        os.umask(before)
    modes = {stat.S_IMODE(p.stat().st_mode) for p in (tmp_path / "cache/er_models").rglob("*")}
    assert modes == {0o700, 0o600}


def test_a_cache_folder_of_ones_own_is_closed_to_others(tmp_path: Path, root: Path) -> None:
    root.chmod(0o777)
    places._settled.cache_clear()
    assert cache_folder() == root
    assert stat.S_IMODE(root.stat().st_mode) == 0o700


def as_another(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The cache folder is somebody else's: it is given away, or this user is another one."""
    if os.geteuid() == 0:
        os.chown(root, NOBODY, NOBODY)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: NOBODY)
    places._settled.cache_clear()


@pytest.mark.parametrize("mode", [0o700, 0o750])
def test_a_cache_folder_of_somebody_else_is_not_used(
    mode: int, tmp_path: Path, root: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    """In its place that of the login, where nobody else can look into it, else one of the process."""
    login = tmp_path / "login"
    login.mkdir()
    login.chmod(mode)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(login))
    as_another(root, monkeypatch)
    found = cache_folder()
    own = mode == 0o700 and os.geteuid() != NOBODY
    assert (found == login / "er_models") == own
    assert stat.S_IMODE(found.stat().st_mode) == 0o700
    assert caplog.messages == [
        f"{root}: it belongs to another user; compiled code is kept in {found}"
    ]
    shutil.rmtree(found)


def test_without_a_home_nothing_stays_behind(tmp_path: Path) -> None:
    """A name that nobody can foretell, and gone with the process."""
    assert run(tmp_path, TMPDIR=str(tmp_path)) == ""
    assert [path.name for path in tmp_path.iterdir()] == ["program.py"]


def test_a_fork_leaves_the_folder_to_its_parent(tmp_path: Path) -> None:
    (tmp_path / "own").mkdir()
    places._remove(tmp_path / "own", os.getpid() + 1)
    assert (tmp_path / "own").exists()
    places._remove(tmp_path / "own", os.getpid())
    assert not (tmp_path / "own").exists()


def test_the_states_last_used_stay(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places, "STATES", 3)
    for i in range(5):
        os.utime(state_folder(f"small-{i}"), (i, i))
    places._made.cache_clear()
    state_folder("small-2")
    state_folder("other-0")
    state_folder("small-5")
    assert {path.name for path in root.iterdir()} == {"small-2", "small-4", "small-5", "other-0"}


def test_a_line_is_said_without_a_logger_set_up(tmp_path: Path) -> None:
    """As errors are: on the error output, and no more than the line."""
    assert logging.getLogger(places.__name__).handlers == []
    (tmp_path / "file").touch()
    lines = run(tmp_path, ER_CACHE_DIR=str(tmp_path / "file"), TMPDIR=str(tmp_path)).splitlines()
    assert len(lines) == 1
    assert lines[0].startswith(
        f"{tmp_path}/file/er_models: File exists; compiled code is kept in "
    )

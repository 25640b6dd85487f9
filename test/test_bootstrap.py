"""./er on bad days: missing tools, broken environments, interruptions, two at once, apt ROS 2.

Each test drives the real ./er and a real pip on a small checkout whose packages are stand-ins.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from test.wheelhouse import fill

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[1]
BASE_PYTHON = os.path.realpath(getattr(sys, "_base_executable", sys.executable))
MANIFEST = "<package format='3'><name>er_one</name></package>\n"
NOWHERE = "/no/such/ros"


class Checkout:
    """A small checkout and the environment to run its ./er in."""

    def __init__(self, root: Path, wheels: Path) -> None:
        """Copy ./er and its tools; one package, three requirements."""
        self.root = root
        root.mkdir()
        shutil.copy2(ROOT / "er", root / "er")
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / "tools", root / "tools", ignore=ignored)
        self.write("requirements/jazzy.txt", "ros-fake==1.0\n")
        self.write("requirements/lock.txt", "numpy==1.0\ncolcon-fake==1.0\n")
        self.write("src/er_one/package.xml", MANIFEST)
        self.write("src/er_one/msg/One.msg", "float64 x\n")
        self.env = {
            "PATH": "/usr/bin:/bin",
            "HOME": str(root),
            "ER_PYTHON": BASE_PYTHON,
            "ER_ROS_PREFIX": NOWHERE,
            "PIP_CONFIG_FILE": os.devnull,
            "PIP_NO_INDEX": "1",
            "PIP_FIND_LINKS": str(wheels),
        }

    def write(self, name: str, text: str) -> Path:
        """Write a file of the checkout."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def start(self, *args: str, **env: str) -> subprocess.Popen[str]:
        """Start ./er."""
        return subprocess.Popen(
            [str(self.root / "er"), *args],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=self.env | env,
            cwd="/",
        )

    def er(self, *args: str, **env: str) -> tuple[int, str, str]:
        """Run ./er; returns status, stdout, stderr."""
        with self.start(*args, **env) as child:
            out, err = child.communicate(timeout=120)
        return child.returncode, out, err

    def builds(self) -> int:
        """How often colcon was called."""
        path = self.root / "builds"
        return len(path.read_text(encoding="utf-8").splitlines()) if path.exists() else 0

    def site(self) -> Path:
        """site-packages of the environment."""
        return next((self.root / ".venv/lib").glob("python3.*/site-packages"))


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of stand-in wheels."""
    folder = tmp_path_factory.mktemp("wheels")
    fill(folder)
    return folder


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory, wheels: Path) -> Checkout:
    """A checkout that is set up; tests may break it, for the next ./er mends it."""
    checkout = Checkout(tmp_path_factory.mktemp("shared") / "checkout", wheels)
    status, _, err = checkout.er("setup")
    assert status == 0, err
    return checkout


@pytest.fixture
def healthy(shared: Checkout) -> Checkout:
    """The shared checkout, mended after the test before."""
    status, _, err = shared.er("setup")
    assert status == 0, err
    return shared


@pytest.fixture
def fresh(tmp_path: Path, wheels: Path) -> Checkout:
    """A checkout that was never set up."""
    return Checkout(tmp_path / "checkout", wheels)


def tools_without(tmp_path: Path, missing: str) -> str:
    """PATH with what ./er starts, except one tool."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for tool in {"sh", "bash", "dirname", "env", "git", "g++"} - {missing}:
        found = shutil.which(tool, path="/usr/bin:/bin")
        assert found is not None
        (folder / tool).symlink_to(found)
    return str(folder)


def python_that(tmp_path: Path, line: str) -> str:
    """An interpreter that runs one line at every start."""
    subprocess.run([BASE_PYTHON, "-m", "venv", "--without-pip", tmp_path / "py"], check=True)
    site = next((tmp_path / "py/lib").glob("python3.*/site-packages"))
    (site / "line.pth").write_text(line + "\n", encoding="utf-8")
    return str(tmp_path / "py/bin/python")


# ---- a machine that lacks something --------------------------------------------------------


@pytest.mark.parametrize("tool", ["git", "g++"])
def test_missing_tool_is_named_with_its_package(
    fresh: Checkout, tmp_path: Path, tool: str
) -> None:
    status, out, err = fresh.er("setup", PATH=tools_without(tmp_path, tool))
    assert (status, out) == (2, "")
    assert err == f"er: {tool} is missing; install it: sudo apt install {tool}\n"
    assert not (fresh.root / ".venv").exists()


def test_missing_ensurepip_names_python3_venv(fresh: Checkout, tmp_path: Path) -> None:
    python = python_that(tmp_path, "import sys; sys.modules['ensurepip'] = None")
    status, _, err = fresh.er("setup", ER_PYTHON=python)
    assert status == 2
    assert "sudo apt install python3-venv" in err
    assert err.count("\n") == 1


def test_missing_headers_name_python3_dev(fresh: Checkout, tmp_path: Path) -> None:
    line = "import sysconfig; sysconfig.get_path = lambda *_: '/no/headers'"
    status, _, err = fresh.er("setup", ER_PYTHON=python_that(tmp_path, line))
    assert status == 2
    assert err.startswith("er: /no/headers/Python.h is missing; install it: sudo apt install")
    assert "python3-dev" in err
    assert err.count("\n") == 1


def test_old_python_is_refused_and_another_one_found(fresh: Checkout, tmp_path: Path) -> None:
    path = tools_without(tmp_path, "")
    old = Path(path) / "python3"
    old.write_text('#!/bin/sh\ncase "$*" in *platform*) echo 3.8.10;; *) exit 1;; esac\n')
    old.chmod(0o755)
    del fresh.env["ER_PYTHON"]
    status, _, err = fresh.er("help", PATH=path)
    assert status == 2
    assert err == (
        "er: Python 3.10 to 3.13 is needed (Debian/Ubuntu package python3), found 3.8.10\n"
    )
    (Path(path) / "python3.11").symlink_to(BASE_PYTHON)
    assert fresh.er("help", PATH=path)[0] == 0


def test_a_python_below_a_name_with_a_space_is_used(fresh: Checkout, tmp_path: Path) -> None:
    python = tmp_path / "my own" / "python3"
    python.parent.mkdir()
    python.symlink_to(BASE_PYTHON)
    status, _, err = fresh.er("help", ER_PYTHON=str(python))
    assert (status, err) == (0, "")


def test_failed_installation_is_one_line_with_the_log(fresh: Checkout) -> None:
    fresh.write("requirements/lock.txt", "no-such-package==3.0\n")
    status, out, err = fresh.er("setup")
    assert (status, out) == (2, "")
    last = err.splitlines()[-1]
    assert last.startswith("er: installing lock.txt failed: ERROR: Could not find a version")
    log = Path(last.split("(log: ")[1].rstrip(")"))
    assert "no-such-package" in log.read_text(encoding="utf-8")
    # the next one cannot reach an index at all, and finds a half-made environment
    address = {"PIP_NO_INDEX": "0", "PIP_INDEX_URL": "http://127.0.0.1:9/simple"}
    status, _, err = fresh.er("setup", **address, PIP_FIND_LINKS="", PIP_RETRIES="1")
    assert status == 2
    assert "making .venv (it was not finished)" in err
    assert "failed: no network, the package index cannot be reached (log: " in err


# ---- a set-up that has something to do, or nothing ------------------------------------------


def test_first_setup_makes_everything_and_repairs_the_wheels(shared: Checkout) -> None:
    cmake = (shared.root / ".venv/share/fake/cmake/fake.cmake").read_text(encoding="utf-8")
    assert "/opt/python" not in cmake
    assert "/numpy/include" in cmake
    include = cmake.split('"')[1].split(";")[0]
    assert (Path(include) / "Python.h").is_file()
    assert (shared.root / "install/.er-stamp").is_file()


def test_second_setup_does_nothing_fast(healthy: Checkout) -> None:
    before, begin = healthy.builds(), time.monotonic()
    status, out, err = healthy.er("setup")
    assert time.monotonic() - begin < 3.0
    assert (status, err) == (0, "")
    assert out == "er: ready (ROS 2 Jazzy from wheels), nothing to do\n"
    assert healthy.builds() == before


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("src/er_one/package.xml", MANIFEST + "<!-- changed -->\n"),
        ("src/er_one/msg/One.msg", "float64 changed\n"),
        ("src/er_one/setup.py", "changed = True\n"),
        ("src/er_two/package.xml", MANIFEST.replace("er_one", "er_two")),
    ],
)
def test_changed_packaging_is_built_without_touching_the_environment(
    healthy: Checkout, name: str, text: str
) -> None:
    before = healthy.builds()
    healthy.write(name, text)
    status, _, err = healthy.er("setup")
    assert status == 0
    assert "making .venv" not in err
    assert healthy.builds() == before + 1


@pytest.mark.parametrize("given", ["", "-j1"])
def test_the_build_uses_every_core_whatever_the_load(healthy: Checkout, given: str) -> None:
    """Without a bound on the load, which what ran before would have reached; who says otherwise is obeyed."""
    healthy.write("src/er_one/package.xml", f"{MANIFEST}<!-- built with '{given}' -->\n")
    assert healthy.er("setup", MAKEFLAGS=given)[0] == 0
    last = (healthy.root / "builds").read_text(encoding="utf-8").splitlines()[-1]
    assert last == (given or f"-j{os.cpu_count()}")


def test_removed_package_is_forgotten(healthy: Checkout) -> None:
    healthy.write("src/er_gone/package.xml", MANIFEST.replace("er_one", "er_gone"))
    healthy.er("setup")
    assert (healthy.root / "install/er_gone").is_dir()
    shutil.rmtree(healthy.root / "src/er_gone")
    assert healthy.er("setup")[0] == 0
    assert not (healthy.root / "install/er_gone").exists()


def test_changed_requirements_update_the_environment_in_place(healthy: Checkout) -> None:
    healthy.write("requirements/lock.txt", "# more\nnumpy==1.0\ncolcon-fake==1.0\n")
    status, _, err = healthy.er("setup")
    assert status == 0
    assert "making .venv" not in err
    assert "installing 1 ROS 2 Jazzy wheels and 2 Python packages" in err


def test_failed_build_is_one_line_and_the_next_one_goes_on(healthy: Checkout) -> None:
    healthy.write("src/er_one/msg/One.msg", "float64 broken\n")
    kept = healthy.write("build/er_one/kept", "object")
    status, _, err = healthy.er("setup", FAKE_ERROR="no such type")
    assert status == 2
    last = err.splitlines()[-1]
    wanted = "er: the build failed: CMake Error at CMakeLists.txt:3: no such type (log: "
    assert last.startswith(wanted)
    assert healthy.er("setup")[0] == 0
    assert kept.exists()


# ---- broken environments ----------------------------------------------------------------------


def break_interpreter(checkout: Checkout) -> None:
    """As after the removal of the Python it was made with."""
    python = checkout.root / ".venv/bin/python"
    for path in python.parent.glob("python*"):
        path.unlink()
    python.symlink_to("/no/such/python3.11")


def break_package(checkout: Checkout) -> None:
    """As after an interrupted removal."""
    shutil.rmtree(checkout.site() / "numpy")


def break_state(checkout: Checkout) -> None:
    """As after a killed installation."""
    (checkout.root / ".venv/er-state.json").unlink()


@pytest.mark.parametrize(
    ("harm", "reason"),
    [
        (break_interpreter, "its Python is gone or another one"),
        (break_package, "numpy is gone"),
        (break_state, "it was not finished"),
    ],
)
def test_broken_environment_heals(healthy: Checkout, harm: object, reason: str) -> None:
    assert callable(harm)
    harm(healthy)
    status, out, err = healthy.er("exec", "python", "-c", "import numpy; print('alive')")
    assert status == 0, err
    assert out == "alive\n"
    assert f"making .venv ({reason})" in err


def test_moved_checkout_is_set_up_anew_also_below_a_name_with_a_space(healthy: Checkout) -> None:
    before = healthy.root
    healthy.root = before.rename(before.with_name("moved here"))
    status, out, err = healthy.er("exec", "env")
    assert status == 0, err
    assert "making .venv (the checkout was moved)" in err
    paths = out.split("AMENT_PREFIX_PATH=")[1].split("\n")[0]
    assert str(healthy.root / "install/er_one") in paths
    assert str(before) + "/" not in paths
    assert node(healthy, "a b", "c") == f"{healthy.root}/.venv ['a b', 'c']\n"


def node(checkout: Checkout, *args: str) -> str:
    """What a program of the build says when it is started as `er up`, ros2 launch and ros2 run start it."""
    program = checkout.root / "install/er_one/lib/er_one/node"
    return subprocess.run([program, *args], capture_output=True, text=True, check=True).stdout


def test_programs_that_no_kernel_can_start_are_mended(healthy: Checkout) -> None:
    """As a build by hand leaves them below a name with a space, or in a very deep folder."""
    program = healthy.root / "install/er_one/lib/er_one/node"
    healthy.write("install/er_one/lib/er_one/node", '#!"/no/such place/python"\nprint(1)\n')
    before = healthy.builds()
    assert healthy.er("setup")[0] == 0
    assert healthy.builds() == before + 1
    assert program.stat().st_mode & 0o111
    assert node(healthy).startswith(f"{healthy.root}/.venv")


# ---- interruptions ----------------------------------------------------------------------------


def interrupted(checkout: Checkout, number: int, seconds: str) -> int:
    """Start a build, end ./er in the middle of it; returns its status."""
    checkout.write("src/er_one/msg/One.msg", f"float64 x{time.monotonic_ns()}\n")
    before = checkout.builds()
    with checkout.start("setup", FAKE_SLEEP=seconds) as child:
        while checkout.builds() == before:
            assert child.poll() is None
            time.sleep(0.02)
        child.send_signal(number)
        return child.wait(timeout=120)


def test_killed_setup_leaves_the_lock_to_its_orphan_and_starts_clean(healthy: Checkout) -> None:
    stale = healthy.write("build/er_one/half-written", "object")
    begin = time.monotonic()
    assert interrupted(healthy, signal.SIGKILL, "3") == -signal.SIGKILL
    status, _, err = healthy.er("setup")
    assert status == 0
    assert "waiting for another ./er" in err
    assert time.monotonic() - begin > 2.5
    assert not stale.exists()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_ended_setup_ends_what_it_started(healthy: Checkout, number: int) -> None:
    begin = time.monotonic()
    assert interrupted(healthy, number, "600") == 128 + number
    status, _, err = healthy.er("setup")
    assert status == 0
    assert "waiting" not in err
    assert time.monotonic() - begin < 240.0


def test_two_at_once_build_once(healthy: Checkout) -> None:
    healthy.write("src/er_one/msg/One.msg", "float64 both\n")
    before = healthy.builds()
    children = [healthy.start("setup", FAKE_SLEEP="1") for _ in range(2)]
    texts = [child.communicate(timeout=60)[1] for child in children]
    assert [child.returncode for child in children] == [0, 0]
    assert healthy.builds() == before + 1
    assert sum("waiting for another ./er" in text for text in texts) == 1


# ---- environments around it --------------------------------------------------------------------


def test_other_ros_and_python_of_the_shell_are_kept_out(healthy: Checkout) -> None:
    foreign = {
        "AMENT_PREFIX_PATH": "/opt/ros/humble",
        "CMAKE_PREFIX_PATH": "/opt/ros/humble",
        "PYTHONPATH": "/opt/ros/humble/lib/python3.10/site-packages:/home/me/tools",
        "PYTHONHOME": "/nowhere",
        "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
        "MY_OWN": "kept",
    }
    status, out, err = healthy.er("exec", "env", **foreign)
    assert status == 0, err
    found = dict(line.split("=", 1) for line in out.splitlines() if "=" in line)
    assert "humble" not in out
    assert found["PYTHONPATH"].endswith("/home/me/tools")
    assert found["MY_OWN"] == "kept"
    assert "RMW_IMPLEMENTATION" not in found
    assert "PYTHONHOME" not in found


def ros_prefix(tmp_path: Path) -> Path:
    """An installed ROS 2: something to source."""
    prefix = tmp_path / "jazzy"
    prefix.mkdir()
    lines = (f"export AMENT_PREFIX_PATH={prefix}", "export ROS_DISTRO=jazzy", "echo noise")
    (prefix / "setup.bash").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return prefix


def test_installed_ros_is_sourced_and_its_packages_are_seen(
    fresh: Checkout, tmp_path: Path
) -> None:
    prefix = ros_prefix(tmp_path)
    fresh.env["ER_ROS_PREFIX"] = str(prefix)
    status, out, err = fresh.er("setup")
    assert status == 0, err
    assert out.startswith(f"er: ready (ROS 2 at {prefix}), set up in ")
    assert "ROS 2 Jazzy wheels" not in err
    config = (fresh.root / ".venv/pyvenv.cfg").read_text(encoding="utf-8")
    assert "include-system-site-packages = true" in config
    _, out, _ = fresh.er("exec", "env")
    assert f"AMENT_PREFIX_PATH={fresh.root}/install/er_one:{prefix}\n" in out
    assert "ROS_DISTRO=jazzy\n" in out
    assert "_ROS_WHEELS_BOOTSTRAP_COMPLETE" not in out
    # without it, the wheels are needed after all
    with fresh.start("setup", ER_ROS_PREFIX=NOWHERE) as child:
        assert child.stderr is not None
        assert child.stderr.readline().startswith("er: making .venv (another ROS 2 is used)")
        child.send_signal(signal.SIGTERM)


def test_installed_ros_without_its_python_is_named(fresh: Checkout, tmp_path: Path) -> None:
    prefix = ros_prefix(tmp_path)
    (prefix / "lib/python3.99").mkdir(parents=True)
    status, _, err = fresh.er("setup", ER_ROS_PREFIX=str(prefix))
    assert status == 2
    assert err == f"er: {prefix} was built for /usr/bin/python3.99, which is not there\n"

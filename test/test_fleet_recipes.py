"""The files of config/fleet, as far as they can be checked without a cluster."""

import ast
import importlib
import re

import pytest
import yaml
from distributed.cli.dask_scheduler import main as scheduler
from distributed.cli.dask_worker import main as worker
from er_model_lab.cli.app import app
from typer.main import get_command

from test.conftest import ROOT
from test.test_manifests import project

FOLDER = ROOT / "config/fleet"
COMPOSE = yaml.safe_load((FOLDER / "compose.yaml").read_text())["services"]
PODS = yaml.safe_load((FOLDER / "kubernetes.yaml").read_text())["spec"]
COMMANDS = [
    *(service["command"] for service in COMPOSE.values()),
    *(PODS[part]["spec"]["containers"][0]["args"] for part in ("scheduler", "worker")),
]


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_command_is_one_that_dask_or_the_lab_takes(words, monkeypatch):
    if words[0] == "dask":
        known = {"scheduler": scheduler, "worker": worker}[words[1]]
        context = known.make_context(words[1], list(words[2:]))
        assert context.args == []
    else:
        assert words[:2] == ["er-lab", "fleet"]
        command = get_command(app).commands["fleet"]
        assert command.make_context("fleet", list(words[2:])).params["data"] == ["/data"]


def test_parts_find_each_other():
    assert {*COMPOSE} == {"scheduler", "worker", "client"}
    assert COMPOSE["worker"]["deploy"]["replicas"] == 2
    assert all("ports" not in service for service in COMPOSE.values())
    assert COMPOSE["worker"]["command"][2] == "tcp://scheduler:8786"
    names = {p["name"] for p in PODS["scheduler"]["spec"]["containers"][0]["ports"]}
    assert {p["targetPort"] for p in PODS["scheduler"]["service"]["ports"]} <= names


def test_folders_are_those_of_the_user_whatever_the_folder_of_the_file():
    """Docker counts a relative path from the file, and makes a missing folder as root."""
    told = (FOLDER / "compose.yaml").read_text()
    mounted = [v for service in COMPOSE.values() for v in service.get("volumes", ())]
    assert [v["target"] for v in mounted] == ["/data", "/data", "/out"]
    for volume in mounted:
        name = re.match(r"\$\{(\w+):\?", volume["source"]).group(1)
        assert f"{name}=$PWD/" in told
        assert volume["bind"] == {"create_host_path": False}
        assert volume.get("read_only", False) is (volume["target"] == "/data")
    assert COMPOSE["client"]["user"].startswith("${ME:?")
    assert "ME=$(id -u):$(id -g)" in told


def test_the_slurm_job_starts_a_worker_that_dask_knows(monkeypatch):
    jobqueue = pytest.importorskip("dask_jobqueue")
    monkeypatch.syspath_prepend(FOLDER)
    with importlib.import_module("slurm").cluster() as jobs:
        script = jobs.job_script().splitlines()
    assert jobqueue.SLURMCluster is type(jobs)
    assert {"#SBATCH -n 1", "#SBATCH -t 04:00:00", "export NUMBA_NUM_THREADS=1"} <= {*script}
    words = script[-1].partition(" -m distributed.cli.dask_worker ")[2].split()
    asked = worker.make_context("worker", words)
    assert asked.args == []
    known = {name: asked.params[name] for name in ("nthreads", "lifetime", "lifetime_stagger")}
    assert known == {"nthreads": 1, "lifetime": "225m", "lifetime_stagger": "10m"}


def test_the_image_asks_for_extras_that_there_are():
    text = (FOLDER / "Dockerfile").read_text()
    asked = re.search(r"er_model_lab\[([\w,]+)\]", text).group(1).split(",")
    assert {*asked} <= project("er_model_lab")["optional-dependencies"].keys()
    assert all((ROOT / place).is_dir() for place in re.findall(r"[ \"]/(src/\w+)", text))


def test_the_slurm_recipe_calls_the_lab_as_it_is():
    tree = ast.parse((FOLDER / "slurm.py").read_text())
    (call,) = [
        n
        for n in ast.walk(tree)
        if isinstance(n, ast.Call) and getattr(n.func, "attr", "") == "fleet"
    ]
    home = ROOT / "src/er_model_lab/er_model_lab/fleets/fleet.py"
    (verb,) = [
        n for n in ast.parse(home.read_text()).body if isinstance(n, ast.FunctionDef) and n.name == "fleet"
    ]  # fmt: skip
    assert {k.arg for k in call.keywords} <= {a.arg for a in verb.args.kwonlyargs}

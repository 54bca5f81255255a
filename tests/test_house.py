"""The shape of the house: who may import whom, and how soon."""

import ast
import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from stages import __main__ as cli
from stages.__main__ import ENVIRONMENT

ROOT = Path(__file__).parent.parent
HEAVY = {
    *("torch", "lerobot", "pybullet", "gymnasium", "datasets", "numpy", "pandas", "scipy", "cv2"),
    "matplotlib",
}

# Imports run one way (design.md, section 3): a package, and those of ours that it may import.
MAY_IMPORT = {
    "pipeline": {"pipeline", "pipeline.data"},  # pipeline.task, the seam to a world
    "pipeline.data": {"pipeline"},
    "pipeline.policies": {"pipeline", "pipeline.data"},
    "pipeline.driving": {"pipeline", "pipeline.data", "pipeline.policies"},
    "pipeline.tasks": {"pipeline", "pipeline.data"},
    "pipeline.rollout": {"pipeline", "pipeline.data", "pipeline.policies"},
    "pipeline.learning": {"pipeline", "pipeline.data", "pipeline.policies"},
    "pipeline.evaluation": {
        "pipeline",
        "pipeline.data",
        "pipeline.driving",
        "pipeline.policies",
        "pipeline.rollout",
        "pipeline.inspection",
    },
    "pipeline.inspection": {
        "pipeline",
        "pipeline.data",
        "pipeline.driving",
        "pipeline.policies",
        "pipeline.rollout",
    },
    "pipeline.claims": {"pipeline", "pipeline.driving", "pipeline.rollout", "pipeline.evaluation"},
    "pipeline.report": {
        "pipeline",
        "pipeline.data",
        "pipeline.driving",
        "pipeline.rollout",
        "pipeline.evaluation",
        "pipeline.claims",
        "pipeline.inspection",
    },
    "pipeline.cards": {
        "pipeline",
        "pipeline.data",
        "pipeline.driving",
        "pipeline.policies",
        "pipeline.rollout",
        "pipeline.evaluation",
    },
}
# Whose words stand only with the car, by name in the registry, and in what draws and reports it.
OF_THE_CAR = re.compile(r"\b(steering|brakes?|lanes?|laps?)\b", re.IGNORECASE)
FREE = (
    "pipeline/*.py",
    *(f"pipeline/{room}/**/*.py" for room in ("data", "policies", "rollout", "learning", "tasks")),
    "stages/*.py",
)
MODULES = sorted(ROOT.glob("pipeline/**/*.py")) + sorted(ROOT.glob("stages/**/*.py"))
STAGES = [path.stem for path in sorted(ROOT.glob("stages/*.py")) if path.stem != "__init__"]


def imports(path: Path) -> Iterator[str]:
    """Full names of what a file imports, wherever in the file that is."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} has a relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def package(name: str) -> str:
    """The part of the house that a module is in: `pipeline.driving`, say, or `pipeline` itself."""
    parts = name.split(".")
    inside = (ROOT / parts[0] / parts[1]).is_dir() if len(parts) > 1 else False
    return ".".join(parts[:2]) if inside else parts[0]


def own_package(path: Path) -> str:
    return package(".".join(path.relative_to(ROOT).with_suffix("").parts))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_run_one_way(path: Path) -> None:
    ours = own_package(path)
    if path == ROOT / "pipeline/__init__.py":
        return  # the public face, which imports nothing but what is asked for: see below
    for name in imports(path):
        if name.split(".")[0] == "pipeline":
            assert ours == "stages" or package(name) in MAY_IMPORT[ours] | {ours}, name
        assert name.split(".")[0] != "tests", name
        assert ours == "stages" or name.split(".")[0] != "stages", name


@pytest.mark.parametrize("path", sorted(ROOT.glob("pipeline/**/*.py")), ids=lambda path: path.stem)
def test_the_library_knows_no_command_line(path: Path) -> None:
    names = {name.split(".")[0] for name in imports(path)}
    assert not names & {"typer", "click", "argparse"}
    tree = ast.parse(path.read_text())
    calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    assert not [call for call in calls if isinstance(call, ast.Name) and call.id == "print"]


@pytest.mark.parametrize("path", sorted(ROOT.glob("stages/*.py")), ids=lambda path: path.stem)
def test_no_stage_imports_a_stage(path: Path) -> None:
    stages = {f"stages.{name.replace('-', '_')}" for name in cli.STAGES}
    assert not stages & set(imports(path))


@pytest.mark.parametrize(
    "path",
    sorted(path for part in FREE for path in ROOT.glob(part)),
    ids=lambda path: str(path.stem),
)
def test_the_method_knows_no_car(path: Path) -> None:
    text = path.read_text()
    if path.name == "registry.py":
        text = re.sub(r'^    "[a-z-]+": "pipeline\.driving\..*",$', "", text, flags=re.MULTILINE)
    assert not OF_THE_CAR.findall(text)


def test_importing_every_stage_imports_nothing_heavy() -> None:
    """So that `--help` answers at once. In a process of its own: here all is imported already."""
    code = f"import sys, {', '.join(f'stages.{stage}' for stage in STAGES)}; print(*sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert not set(run.stdout.split()) & HEAVY


def test_the_public_face_is_what_type_checkers_see_and_costs_nothing() -> None:
    import pipeline

    told = {name.rpartition(".")[2]: name for name in imports(ROOT / "pipeline/__init__.py")}
    for name in pipeline.__all__:
        assert getattr(pipeline, name).__module__ == told[name].rpartition(".")[0]
    assert told.keys() - {"import_module", "TYPE_CHECKING", "Any"} == set(pipeline.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'Novice'"):
        pipeline.Novice  # noqa: B018
    code = "import sys, pipeline; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, check=True)
    assert not set(run.stdout.decode().split()) & HEAVY


def test_the_library_datasets_is_not_shadowed() -> None:
    """datasets/ holds data; an __init__.py there would take the place of the library."""
    spec = importlib.util.find_spec("datasets")
    assert "site-packages" in spec.origin
    for folder in ("datasets", "models", "cards"):
        assert not list((ROOT / folder).glob("*.py"))


def test_every_folder_of_code_is_a_package() -> None:
    for path in MODULES:
        assert (path.parent / "__init__.py").is_file()


def test_no_import_changes_the_environment() -> None:
    """A user's script must be able to push to the Hub: commands set what they need for themselves."""
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in MODULES
    ]
    code = (
        "import importlib, os, sys; before = dict(os.environ);"
        "[importlib.import_module(name) for name in sys.argv[1:]];"
        "print({k for k in os.environ.keys() | before.keys() if os.environ.get(k) != before.get(k)})"
    )
    clean = {k: v for k, v in os.environ.items() if k not in ENVIRONMENT}
    run = subprocess.run(
        [sys.executable, "-c", code, *modules],
        cwd=ROOT,
        env=clean,
        capture_output=True,
        text=True,
        check=True,
    )
    changed = ast.literal_eval(run.stdout.replace("set()", "{}"))
    assert not set(changed) & ({*ENVIRONMENT} | {"HF_DATASETS_OFFLINE", "OMP_NUM_THREADS"})


def test_commands_work_offline(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ENVIRONMENT:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "argv", ["safedagger", "--help"])
    with pytest.raises(SystemExit):
        cli.main()
    assert {name: os.environ[name] for name in ENVIRONMENT} == ENVIRONMENT

"""What `pip install .` installs: all of the code, and nothing but it."""

import os
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
COLLECT = (
    "collect D_0 --purpose D_0 --iteration 0 --tracks alder --traffic 2 --episodes 1 --seconds 1"
    " --offset-spread 0.3 --angle-spread 0.03 --action-repeat 3 --seed 1 --workers 1"
)


@pytest.fixture(scope="module")
def tracked() -> list[str]:
    """What git has of this checkout."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return listed.stdout.split("\0")[:-1]


@pytest.fixture(scope="module")
def wheel(tracked: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, unpacked. It is built from a copy: setuptools leaves files where it builds."""
    root = tmp_path_factory.mktemp("wheel")
    for name in tracked:
        (root / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, root / "source" / name)
    pip = [sys.executable, "-m", "pip", "wheel", "--no-index", "--no-build-isolation", "--no-deps"]
    subprocess.run([*pip, "--wheel-dir", root, root / "source"], check=True)
    (built,) = root.glob("*.whl")
    with zipfile.ZipFile(built) as archive:
        archive.extractall(root / "unpacked")
    return root / "unpacked"


def python(wheel: Path, folder: Path, *arguments: str) -> str:
    """What Python prints in a folder, with the wheel's code and this environment's libraries.

    Without `site` (-S) the environment's .pth files are not read: an editable install would put
    the checkout's modules where the wheel lacks them.
    """
    done = subprocess.run(
        [sys.executable, "-S", "-P", *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": f"{wheel}{os.pathsep}{sysconfig.get_path('purelib')}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_has_all_of_the_code_and_nothing_else(wheel: Path, tracked: list[str]) -> None:
    files = {str(path.relative_to(wheel)) for path in wheel.rglob("*") if path.is_file()}
    packed = {name for name in files if ".dist-info/" not in name}
    assert packed == {name for name in tracked if name.startswith(("pipeline/", "stages/"))}


def test_the_wheel_runs_without_a_checkout(wheel: Path, tmp_path: Path) -> None:
    found = python(
        wheel, tmp_path, "-c", "import pipeline, stages; print(pipeline.__file__, stages.__file__)"
    )
    assert found.split() == [str(wheel / name / "__init__.py") for name in ("pipeline", "stages")]
    assert "train-primary" in python(wheel, tmp_path, "-m", "stages", "--help")
    python(wheel, tmp_path, "-m", "stages", *COLLECT.split())
    assert (tmp_path / "D_0" / "meta" / "info.json").is_file()


def test_the_license_is_in_the_wheel(wheel: Path) -> None:
    (metadata,) = wheel.glob("*.dist-info")
    assert (metadata / "licenses" / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert f"License-Expression: {PROJECT['license']}\n" in (metadata / "METADATA").read_text()
    assert PROJECT["license"] == "Apache-2.0"
    assert (
        "Apache License\n                           Version 2.0" in (ROOT / "LICENSE").read_text()
    )


def test_the_citation_agrees_with_the_project() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert (citation["cff-version"], citation["type"]) == ("1.2.0", "software")
    for ours, theirs in (("title", "name"), ("version", "version"), ("license", "license")):
        assert citation[ours] == PROJECT[theirs]
    assert citation["message"] and citation["authors"] == [{"name": "The safedagger authors"}]
    (paper,) = citation["references"]
    assert [author["family-names"] for author in paper["authors"]] == ["Zhang", "Cho"]
    assert paper["year"] == 2016
    assert paper["identifiers"] == [{"type": "other", "value": "arXiv:1605.06450"}]

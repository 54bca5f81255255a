"""The stage `report` writes all of it or refuses in one line."""

import shutil
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from pipeline.report.figures import TITLES
from stages.report import ERRORS, FRAMES, report
from tests.evaluation.made_up_curves import write_seed
from tests.evaluation.sample import write_run

TRAINING = {"strategies.png", "strategies_takeover.png", "strategies_cost.png"}
APP = typer.Typer()
APP.command()(report)
ALWAYS = {"result.png", "calibration.png", "training.png", "test.png"}


def arguments(root: Path, seeds: int = 1) -> list[str]:
    """Of the stage, on SafeDAgger's run of some seeds, with their pictures."""
    for seed in range(seeds):
        write_run(root / "metrics" / f"seed_{seed}")
        for kind in ("errors", "frames"):
            (root / kind).mkdir(exist_ok=True)
            (root / kind / f"seed_{seed}.png").write_bytes(b"drawn")
    places = {kind: root / kind for kind in ("metrics", "errors", "frames")}
    places |= {"output": root / "cards" / "report.md", "figures": root / "cards" / "png"}
    return [str(word) for name, path in places.items() for word in (f"--{name}", path)]


def test_it_writes_all_or_refuses(tmp_path: Path) -> None:
    given = arguments(tmp_path, seeds=2)
    output, figures = tmp_path / "cards" / "report.md", tmp_path / "cards" / "png"
    result = CliRunner().invoke(APP, given)
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines() == [f"{output}: 8 steps, 7 figures in {figures}"]
    names = {file.name for file in figures.iterdir()}
    assert names == TRAINING | ALWAYS
    text = output.read_text()
    shown = [*(f"png/{name}" for name in names), "../errors/seed_0.png", "../frames/seed_1.png"]
    assert all(f"]({place})" in text for place in shown)
    assert "no picture" not in text

    shutil.rmtree(tmp_path / "cards")
    for path in (output, figures / "optimal.png", figures / "test.png"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("precious")
        again = CliRunner().invoke(APP, given)
        assert isinstance(again.exception, FileExistsError)
        assert [file for file in (tmp_path / "cards").rglob("*") if file.is_file()] == [path]
        assert path.read_text() == "precious"
        path.unlink()


def test_variants_and_the_optimal_safety_policy_are_drawn_where_there_are(tmp_path: Path) -> None:
    given = arguments(tmp_path)
    folder = tmp_path / "metrics" / "seed_0"
    for file in sorted(folder.glob("*_safedagger_?.*")):
        shutil.copy(file, folder / file.name.replace("safedagger", "safedagger_last"))
    csv = folder / "drives_safedagger_last_2.csv"
    lines = csv.read_text().splitlines()
    optimal = [line.replace("safe,", "optimal,") for line in lines if ",safe," in line]
    csv.write_text("\n".join([*lines, *optimal]) + "\n")
    result = CliRunner().invoke(APP, given)
    assert result.exit_code == 0, result.output
    drawn = {file.name for file in (tmp_path / "cards" / "png").iterdir()}
    assert drawn == {f"{name}.png" for name in TITLES} | ALWAYS


def test_label_curves_come_first_where_there_are(tmp_path: Path) -> None:
    given = arguments(tmp_path)
    of_loop = [f"dagger4000_{i}" for i in (1, 2, 3)]
    write_seed(tmp_path / "curves" / "seed_4", "0", *of_loop)
    result = CliRunner().invoke(APP, [*given, "--curves", str(tmp_path / "curves")])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "cards" / "png" / "labels.png").is_file()
    text = (tmp_path / "cards" / "report.md").read_text()
    assert text.index("](png/labels.png)") < text.index("](png/result.png)")
    assert "| DAgger, 4,000 labels | 4, 1 | 300 | 400 |" in text


def test_a_seed_without_a_picture_is_named_in_the_report(tmp_path: Path) -> None:
    given = arguments(tmp_path, seeds=2)
    (tmp_path / "errors" / "seed_0.png").unlink()
    for seed in range(2):
        (tmp_path / "frames" / f"seed_{seed}.png").unlink()
    assert CliRunner().invoke(APP, given).exit_code == 0
    text = (tmp_path / "cards" / "report.md").read_text()
    assert f"- {ERRORS}, seed 0: no picture." in text
    assert f"- {FRAMES}, seed 1: no picture." in text
    assert f"![{ERRORS}, seed 1](../errors/seed_1.png)" in text
    assert f"![{FRAMES}" not in text


@pytest.mark.parametrize("missing", ["metrics/seed_0/rollout_safedagger_3.json", "frames"])
def test_it_writes_nothing_where_something_is_missing(tmp_path: Path, missing: str) -> None:
    given, path = arguments(tmp_path), tmp_path / missing
    path.rename(tmp_path / "elsewhere")
    result = CliRunner().invoke(APP, given)
    assert isinstance(result.exception, FileNotFoundError)
    assert str(result.exception).startswith(f"{path}: no such ")
    assert not (tmp_path / "cards").exists()

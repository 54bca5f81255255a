"""The stage `report` writes all of it or refuses in one line."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.report.figures import TITLES
from stages.report import ERRORS, FRAMES
from tests.command import run
from tests.evaluation.made_up_curves import write_seed
from tests.evaluation.written import write_run

TRAINING = {"strategies.png", "strategies_takeover.png", "strategies_cost.png"}
ALWAYS = {"result.png", "calibration.png", "training.png", "test.png"}
REPORT = (
    "report --metrics metrics --errors errors --frames frames "
    "--output cards/report.md --figures cards/png"
)
OUTPUT, FIGURES = Path("cards/report.md"), Path("cards/png")


@pytest.fixture(autouse=True)
def _house(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """SafeDAgger's run of two seeds, with their pictures, to stand in."""
    monkeypatch.chdir(tmp_path)
    write_run(Path("metrics"), seeds=2)
    for seed in range(2):
        for kind in ("errors", "frames"):
            Path(kind).mkdir(exist_ok=True)
            Path(f"{kind}/seed_{seed}.png").write_bytes(b"drawn")


def test_it_writes_all_or_refuses(
    refused: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(REPORT) == 0
    assert capsys.readouterr().out == f"{OUTPUT}: 8 steps, 7 figures in {FIGURES}\n"
    names = {file.name for file in FIGURES.iterdir()}
    assert names == TRAINING | ALWAYS
    text = OUTPUT.read_text()
    shown = [*(f"png/{name}" for name in names), "../errors/seed_0.png", "../frames/seed_1.png"]
    assert all(f"]({place})" in text for place in shown)
    assert "no picture" not in text

    for path in (OUTPUT, FIGURES / "optimal.png", FIGURES / "test.png"):
        shutil.rmtree("cards")
        path.parent.mkdir(parents=True)
        path.write_text("precious")
        assert refused(REPORT).startswith(f"{path}: exists already")


def test_variants_and_the_optimal_safety_policy_are_drawn_where_there_are() -> None:
    folder = Path("metrics/seed_0")
    for file in sorted(folder.glob("*_safedagger_?.*")):
        shutil.copy(file, folder / file.name.replace("safedagger", "safedagger_last"))
    csv = folder / "drives_safedagger_last_2.csv"
    lines = csv.read_text().splitlines()
    optimal = [line.replace("safe,", "optimal,") for line in lines if ",safe," in line]
    csv.write_text("\n".join([*lines, *optimal]) + "\n")
    assert run(REPORT) == 0
    drawn = {file.name for file in FIGURES.iterdir()}
    assert drawn == {f"{name}.png" for name in TITLES} | ALWAYS


def test_label_curves_come_first_where_there_are() -> None:
    write_seed(Path("curves/seed_4"), "0", *(f"dagger4000_{i}" for i in (1, 2, 3)))
    assert run(f"{REPORT} --curves curves") == 0
    assert (FIGURES / "labels.png").is_file()
    text = OUTPUT.read_text()
    assert text.index("](png/labels.png)") < text.index("](png/result.png)")
    assert "| DAgger, 4,000 labels | 4, 1 | 300 | 400 |" in text


def test_a_seed_without_a_picture_is_named_in_the_report() -> None:
    for picture in ("errors/seed_0", "frames/seed_0", "frames/seed_1"):
        Path(f"{picture}.png").unlink()
    assert run(REPORT) == 0
    text = OUTPUT.read_text()
    assert f"- {ERRORS}, seed 0: no picture." in text
    assert f"- {FRAMES}, seed 1: no picture." in text
    assert f"![{ERRORS}, seed 1](../errors/seed_1.png)" in text
    assert f"![{FRAMES}" not in text


@pytest.mark.parametrize("missing", ["metrics/seed_0/rollout_safedagger_3.json", "frames"])
def test_it_writes_nothing_where_something_is_missing(
    missing: str, refused: Callable[..., str]
) -> None:
    Path(missing).rename("elsewhere")
    assert refused(REPORT).startswith(f"{missing}: no such ")

"""The committed report says what the committed metrics say, and the README what the report says."""

import re
from pathlib import Path

import pandas as pd
import pytest

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import column
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.reading import read_crowd, read_reliability
from tests.command import run

ROOT = Path(__file__).parents[2]
NAMES = ("metrics", "curves", "errors", "frames")


def test_the_committed_report_is_a_fresh_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else: `dvc repro report`. Its words and numbers; pictures are drawn otherwise by other fonts."""
    (tmp_path / "cards").mkdir()
    for name in NAMES:
        (tmp_path / "cards" / name).symlink_to(ROOT / "cards" / name)
    monkeypatch.chdir(tmp_path)
    folders = " ".join(f"--{name} cards/{name}" for name in NAMES)
    assert run(f"report {folders} --output cards/report.md --figures cards/figures") == 0
    fresh = (tmp_path / "cards/report.md").read_text()
    assert fresh == (ROOT / "cards/report.md").read_text()
    drawn = {path.name for path in (tmp_path / "cards/figures").iterdir()}
    assert drawn == {path.name for path in (ROOT / "cards/figures").iterdir()}


RUNS = {  # what the README's table calls them
    "DAgger, 3": ("DAgger", "3"),
    "DAgger at equal queries, 3": ("DAgger, SafeDAgger's queries", "3"),
    "supervised, 3": ("supervised", "3"),
}


def test_the_readme_has_the_iterations_of_the_report() -> None:
    report = (ROOT / "cards/report.md").read_text()
    laps, driven, asked = (
        {
            (run, iteration): cells
            for run, iteration, *cells in _rows(report, f"Run | Iteration | {of}")
        }
        for of in ("Laps, naive", "Takeover, safe", "Queries so far")
    )
    shown = _rows((ROOT / "README.md").read_text(), "iteration")
    assert len(shown) == 7
    for name, *cells in shown:
        at = RUNS.get(name, ("SafeDAgger", name[0]))
        assert cells == [*laps[at][:2], driven[at][0], asked[at][0]]


def test_the_readme_has_what_the_verdicts_observed() -> None:
    report = (ROOT / "cards/report.md").read_text()
    said = " ".join((ROOT / "README.md").read_text().split())
    evidence = dict(re.findall(r"^(\d+)\. (.*)$", report, re.MULTILINE))
    less = r"iterations 1 to 3 against DAgger's: ([\d.]+ %) against ([\d.]+ %)"
    ours, theirs = re.findall(less, evidence["6"])[-1]
    assert f"{ours} of the time against {theirs} after DAgger, over iterations 1 to 3" in said
    sooner = r"after ([\d,]+) queries; SafeDAgger as far, within 0.1: surely after ([\d,]+)"
    [(dagger, after)], [(budget, same)] = (re.findall(sooner, evidence[c]) for c in ("12", "13"))
    assert after == same and f"second iteration, with {after} queries; DAgger's after the" in said
    assert f"first, with {dagger}," in said and f"the third, with {budget}," in said
    counted = (
        re.findall(r"^(\d+) failures? in ([\d,]+) frames", evidence[claim])
        for claim in ("16", "17", "18")
    )
    [(once, frames)], [(many, more)], [(some, fewer)] = counted
    assert f"touched a car {once} times in {frames} frames" in said
    assert f"failed {many} times in {more}, and {some} times in {fewer}" in said


def test_the_readme_has_what_an_optimal_safety_policy_would_leave_to_the_reference() -> None:
    found = []
    for loop in ("safedagger", "dagger"):
        files = (ROOT / "cards/metrics").glob(f"seed_*/drives_{loop}_[123].csv")
        drives = pd.concat(map(pd.read_csv, files))
        asked = drives[(drives.strategy == "optimal") & (drives.traffic > 0)]
        found.append(100 * asked.takeover_frames.sum() / asked.frames.sum())
    said = " ".join((ROOT / "README.md").read_text().split())
    assert "would make it {:.1f} and {:.1f} %".format(*found) in said


def test_the_readme_has_how_far_the_last_primaries_can_be_relied_on() -> None:
    """Alone, and in a crowd."""
    said = " ".join((ROOT / "README.md").read_text().split())
    alone, crowd = (_done(read(ROOT / "cards/metrics")) for read in (read_reliability, read_crowd))
    words = (
        "SafeDAgger did {safedagger} of {drives} laps alone, DAgger's {dagger}, DAgger's at equal "
        "queries {dagger_budget}, the supervised one {supervised}, and pi_0 {pi_0};"
    )
    assert words.format(**alone) in said
    words = "among 40 cars {safedagger}, {dagger}, {dagger_budget}, {supervised} and {pi_0} of {drives}."
    assert words.format(**crowd) in said


def _done(found: Experiment) -> dict[str, int]:
    """Of the last primaries and the first: on how many drives each had no failure, of how many."""
    steps = {run: (run, 3) for run in ("safedagger", "dagger", "dagger_budget", "supervised")}
    steps["pi_0"] = ("supervised", 0)
    drives = {name: found.among(run=run, iteration=i) for name, (run, i) in steps.items()}
    (of,) = {len(each) for each in drives.values()}
    success = METRICS["success"].part
    return {name: int(column(each, success).sum()) for name, each in drives.items()} | {
        "drives": of
    }


def _rows(page: str, begins: str) -> list[list[str]]:
    """The cells of the table whose head begins like this, without intervals."""
    table = page.partition(f"\n| {begins}")[2].partition("\n\n")[0]
    return [
        [re.sub(r" \[[^]]*\]", "", cell).strip() for cell in line.strip("| ").split("|")]
        for line in table.splitlines()[2:]
    ]

"""What is committed of the report is what the committed metrics say."""

from pathlib import Path

import pytest

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

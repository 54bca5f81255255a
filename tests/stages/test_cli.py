"""The commands as a user meets them: quick help, and one line for bad input."""

import subprocess
import sys
from pathlib import Path

import pytest

from stages import __main__ as cli

STAGES = [
    "collect",
    "train-primary",
    "train-safety",
    "rollout",
    "select",
    "rollout-dagger",
    "sample",
    "merge",
    "ledger",
    "evaluate",
    "errors",
    "contact-sheet",
    "film",
    "cards",
    "report",
    "inspect",
    "compare",
    "watch",
]
HEAVY = {"torch", "lerobot", "pybullet", "numpy", "matplotlib", "datasets"}

DRIVES = {
    "--tracks": "alder",
    "--traffic": "2",
    "--seconds": "1",
    "--offset-spread": "0.3",
    "--angle-spread": "0.05",
    "--record-every": "2",
    "--seed": "0",
    "--workers": "1",
}
COLLECT = DRIVES | {"--episodes": "1", "--purpose": "D_0", "--iteration": "0"}


def run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *arguments: object
) -> tuple[int, str]:
    """Exit code and stderr of a command, run in this process."""
    monkeypatch.setattr(sys, "argv", ["safedagger", *map(str, arguments)])
    with pytest.raises(SystemExit) as exit_:
        cli.main()
    code = exit_.value.code
    return (code if isinstance(code, int) else 0), capsys.readouterr().err


def flat(options: dict[str, str]) -> list[str]:
    return [word for pair in options.items() for word in pair]


def test_help_needs_nothing_heavy() -> None:
    code = "import sys; import stages.__main__; print(*{m.split('.')[0] for m in sys.modules})"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert not HEAVY & set(loaded.stdout.split())


@pytest.mark.parametrize("stage", STAGES)
def test_each_stage_explains_itself(
    stage: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["safedagger", stage, "--help"])
    with pytest.raises(SystemExit) as exit_:
        cli.main()
    assert exit_.value.code == 0
    assert f"safedagger {stage}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"--tracks": "nowhere"}, "nowhere"),
        ({"--traffic": "-1"}, "--traffic"),
        ({"--traffic": "9000"}, "9000"),
        ({"--seconds": "-3"}, "--seconds"),
        ({"--seconds": "nan"}, "seconds"),
        ({"--episodes": "0"}, "--episodes"),
        ({"--record-every": "7"}, "record_every"),
        ({"--purpose": "fun"}, "--purpose"),
        ({"--workers": "0"}, "--workers"),
    ],
)
def test_collect_refuses_nonsense_in_one_line(
    change: dict[str, str],
    named: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    code, error = run(capsys, monkeypatch, "collect", tmp_path / "out", *flat(COLLECT | change))
    assert code == 2
    assert len(error.strip().splitlines()) == 1
    assert named in error
    assert list(tmp_path.iterdir()) == []


def test_an_output_that_exists_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").write_text("precious")
    code, error = run(capsys, monkeypatch, "collect", tmp_path / "out", *flat(COLLECT))
    assert code == 2
    assert "exists" in error
    assert (tmp_path / "out" / "mine").read_text() == "precious"


@pytest.mark.parametrize(
    "arguments",
    [
        ("select", "missing", "out", "--cut", "0.5"),
        ("contact-sheet", "missing", "out", "--frames", "3"),
        ("inspect", "missing"),
        ("compare", "missing", "missing"),
        ("sample", "missing", "out", "--frames", "3", "--seed", "0"),
        ("merge", "missing", "missing", "out"),
        ("ledger", "missing", "missing", "--metrics", "out"),
        (
            "cards",
            *("--datasets", "missing", "--models", "missing", "--metrics", "missing"),
            *("--tau", "0.0025", "--record-every", "3"),
            *("--dataset-cards", "out", "--model-cards", "out_too"),
        ),
        (
            "report",
            "--metrics",
            "missing",
            "--errors",
            "missing",
            "--frames",
            "missing",
            "--output",
            "out",
            "--figures",
            "figures",
        ),
        (
            "rollout",
            "missing",
            "missing",
            "out",
            *flat(DRIVES),
            "--queries",
            "1",
            "--frames",
            "1",
            "--cut",
            "0.5",
            "--iteration",
            "1",
            "--metrics",
            "m",
        ),
    ],
)
def test_missing_input_is_named_and_nothing_is_written(
    arguments: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    code, error = run(capsys, monkeypatch, *arguments)
    assert code == 2
    assert len(error.strip().splitlines()) == 1
    assert "missing" in error
    assert list(tmp_path.iterdir()) == []

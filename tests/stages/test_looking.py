"""The commands that show something, each into a file."""

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pipeline.data.dataset import Dataset
from pipeline.inspection.excerpts import ranked_takeovers
from tests.command import run
from tests.data.spoiling import drop_column
from tests.drives import save_untrained
from tests.episodes import random_episode, write
from tests.inspection.saved import column, origins, recordings

BOTH = "primary safety primary_b safety_b"
CAR = "--tracks willow --traffic 3 --seconds 0.5 --action-repeat 3"
WATCH = f"{CAR} --seed 1"
NAIVE = f"{WATCH} --strategy naive"
FILM = f"{NAIVE} --show-every 1"
EVALUATE = f"{WATCH} --starts 1 --workers 1"
UNDRAWN = "task is 'tests.stages.pendulum:Pendulum', expected one that can be drawn: driving"
PENDULUM = "--task tests.stages.pendulum:Pendulum --length 1 --seed 1"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two datasets, and two primaries with their safety policies."""
    root = tmp_path_factory.mktemp("made")
    rng = np.random.default_rng(0)
    for name in ("a", "b"):
        episode = random_episode(rng, 20, task="drive on yew with 2 other cars")
        write(root / name, [episode])
    for seed, ending in enumerate(("", "_b")):
        save_untrained(root / f"primary{ending}", root / f"safety{ending}", seed)
    return root


@pytest.fixture(autouse=True)
def _stand_in(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(made)


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("inspect a", "a/episode_0000"),
        ("compare a b", "yew/a_0/b_0"),
        (f"watch {WATCH} --strategy reference", "willow/reference/1"),
        (f"watch {CAR}", "willow/reference/0"),
        (f"watch primary {CAR}", "willow/naive/0"),
        (f"watch primary safety {CAR}", "willow/safe/0"),
        (f"watch primary safety {NAIVE}", "willow/naive/1"),
        (f"watch primary {NAIVE}", "willow/naive/1"),
        (f"watch primary {WATCH} --strategy reference", "willow/reference/1"),
        (f"watch primary safety {WATCH} --strategy safe", "willow/safe/1"),
        (f"watch primary safety {WATCH} --strategy optimal", "willow/optimal/1"),
        (f"compare-policies {BOTH} {NAIVE}", "willow/naive/1/primary/primary_b"),
    ],
)
def test_a_file_for_rerun(
    typed: str, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "shown.rrd"
    assert run(f"{typed} --save {path}") == 0
    assert [entry.recording_id for entry in recordings(path)] == [expected]
    *before, last = capsys.readouterr().out.splitlines()
    assert last == f"{path}: open it with `rerun {path}`"
    if typed.startswith("compare-policies"):
        assert [line.split(":")[0] for line in before] == ["a, primary", "b, primary_b"]
    if typed.startswith("watch"):
        assert "who" in origins(path)
        assert before[-1].startswith("0.0") and " laps, damage 0.00, 5 frames" in before[-1]
    if "--tracks" in typed:
        assert all(line.endswith("takeovers; ended: out of time") for line in before)


def test_takeovers_are_listed_as_they_are_ranked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(f"inspect a --unsafe --save {tmp_path}/x.rrd") == 0
    *listed, size, _ = capsys.readouterr().out.splitlines()
    expected = ranked_takeovers(Dataset.open(Path("a")))
    assert listed == [f"{rank:04d}: {takeover}" for rank, takeover in enumerate(expected, 1)]
    frames = sum(takeover.end - takeover.first for takeover in expected)
    about = f"{len(expected)} recordings, {frames} frames: about "
    assert size.startswith(about)
    written = (tmp_path / "x.rrd").stat().st_size / 1e6
    assert written / 2 < float(size.removeprefix(about).removesuffix(" MB")) < written * 2


def test_a_film_and_a_recording_are_of_one_drive(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With equal seeds, by whatever strategy: where both drive, the outcome is the same."""
    drive = f"{CAR} --seconds 3 --seed 7 --strategy"
    for policies, strategy in (("primary safety", "safe"), ("primary", "naive")):
        typed, path = f"{policies} {drive} {strategy}", tmp_path / strategy
        assert run(f"film {typed} --show-every 9 --output {path}.gif") == 0
        filmed = capsys.readouterr().out.splitlines()[-1].partition("pictures; ")[2]
        assert run(f"watch {typed} --save {path}.rrd") == 0
        assert filmed in capsys.readouterr().out.splitlines()


def test_driving_naively_needs_no_safety_policy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """And is the same drive with one: filmed, and evaluated."""
    shown = {}
    for name, policies in (("with", "primary safety"), ("without", "primary")):
        film, drives, metrics = (tmp_path / f"{name}.{kind}" for kind in ("gif", "csv", "json"))
        assert run(f"film {policies} {FILM} --output {film}") == 0
        assert capsys.readouterr().out.endswith("0 takeovers; ended: out of time\n")
        places = f"--drives {drives} --metrics {metrics}"
        assert run(f"evaluate {policies} {EVALUATE} {places} --strategies naive") == 0
        assert ", 0 of them by the reference; ended: out of time 2\n" in capsys.readouterr().out
        shown[name] = [path.read_bytes() for path in (film, drives, metrics)]
    assert shown["with"] == shown["without"]


def test_a_condition_is_evaluated_alone_as_among_others(tmp_path: Path) -> None:
    for name, told in (("both", ""), ("one", "--conditions traffic")):
        places = f"--drives {tmp_path}/{name}.csv --metrics {tmp_path}/{name}.json"
        assert run(f"evaluate primary {EVALUATE} {told} {places}") == 0
    both, one = ([*csv.DictReader((tmp_path / f"{name}.csv").open())] for name in ("both", "one"))
    assert one == [row for row in both if row["condition"] == "traffic"] != []
    both, one = (
        json.loads((tmp_path / f"{name}.json").read_text())["rows"] for name in ("both", "one")
    )
    assert one == [row for row in both if row["condition"] == "traffic"]


def test_an_evaluation_says_what_was_set_by_hand(tmp_path: Path) -> None:
    for name, calm in (("paper", ""), ("calm", "--cut 0.4 --resume 0.7 --least 1")):
        places = f"--drives {tmp_path}/{name}.csv --metrics {tmp_path}/{name}.json"
        typed = f"evaluate primary safety {EVALUATE} --strategies safe {calm} {places}"
        assert run(typed) == 0
    paper, other = (
        json.loads((tmp_path / f"{name}.json").read_text())["rows"] for name in ("paper", "calm")
    )
    assert other == [row | {"cut": 0.4, "resume": 0.7, "least": 1.0} for row in paper]


def test_a_film_of_two_is_as_wide_as_both(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alone, both = tmp_path / "alone.gif", tmp_path / "both.gif"
    assert run(f"film primary safety {FILM} --output {alone}") == 0
    assert run(f"film primary safety --beside primary_b safety_b {FILM} --output {both}") == 0
    assert capsys.readouterr().out.splitlines()[1].count("ended: out of time") == 2
    (width, height), wider = (Image.open(path).size for path in (alone, both))
    assert wider == (2 * width, height)


def test_each_side_is_driven_by_its_own_policies(tmp_path: Path) -> None:
    """What a and b propose and believe is what `watch` shows of them alone."""
    pair, alone_a, alone_b = (tmp_path / f"{name}.rrd" for name in ("pair", "a", "b"))
    assert run(f"compare-policies {BOTH} {NAIVE} --save {pair}") == 0
    assert run(f"watch primary safety {NAIVE} --save {alone_a}") == 0
    assert run(f"watch primary_b safety_b {NAIVE} --save {alone_b}") == 0
    for entity in ("action/primary_steering", "safe_probability/safe_probability"):
        a, b, *expected = (
            column(path, recordings(path)[0], f"/{root}{entity}", "scalars")
            for path, root in ((pair, "a/"), (pair, "b/"), (alone_a, ""), (alone_b, ""))
        )
        assert [a, b] == expected and a != b


@pytest.mark.parametrize(
    ("typed", "named"),
    [
        ("inspect a --save x.rrd --web", "exclude each other"),
        ("inspect a --port 9000", "--port is where --web serves its page"),
        ("compare a b --drive 1", "no drive 1"),
        (f"watch {NAIVE}", "strategy is naive, which needs a primary"),
        ("watch primary --tracks oak", "track 'oak': expected one of"),
        (f"watch primary {WATCH} --strategy safe", "is safe, which needs a safety policy"),
        (
            f"film primary {FILM} --output x.gif --strategy optimal",
            "strategy is optimal, which needs a safety policy",
        ),
        (
            f"evaluate primary {EVALUATE} --metrics x.json --drives x --strategies naive,safe",
            "strategy is safe, which needs a safety policy",
        ),
        (
            f"evaluate primary {EVALUATE} --metrics x.json --drives x --conditions traffic,rain",
            "--conditions 'rain': expected some of no_traffic, traffic",
        ),
        (f"watch safety primary {WATCH} --strategy safe", "expected"),
        (f"watch {CAR} --tracks nowhere", "nowhere"),
        (f"watch {CAR} --tracks yew,alder", "'yew,alder', expected a"),
        (f"film primary {FILM} --output x.gif --tracks yew,alder", "'yew,alder', expected a"),
        (f"compare-policies {BOTH} {NAIVE} --tracks yew,alder", "'yew,alder', expected a"),
        (f"watch {PENDULUM} --strategy reference", UNDRAWN),
        (f"film primary {PENDULUM} --show-every 1 --strategy naive --output x.gif", UNDRAWN),
        (f"compare-policies {BOTH} {PENDULUM} --strategy naive", UNDRAWN),
        (f"watch {CAR} --action-repeat 7", "action_repeat"),
        (f"watch {WATCH} --strategy mixture", "--strategy"),
        (f"compare-policies {BOTH} {WATCH} --strategy reference", "reference"),
        (f"compare-policies a safety b safety {WATCH} --strategy safe", "a/"),
    ],
)
def test_nonsense_is_one_line(
    typed: str, named: str, made: Path, refused: Callable[..., str]
) -> None:
    assert named in refused(typed, made)


def test_a_car_that_lacks_a_column_is_one_line(
    made: Path, tmp_path: Path, refused: Callable[..., str]
) -> None:
    lacking = tmp_path / "lacking"
    shutil.copytree(made / "a", lacking)
    drop_column("affordances")(lacking)
    for typed in (f"inspect {lacking}", f"compare {made / 'a'} {lacking}"):
        assert "lacking: column 'affordances' is missing" in refused(typed)

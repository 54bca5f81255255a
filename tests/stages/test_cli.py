"""The commands as a user meets them: quick help, and one line for bad input."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import typer

from stages import __main__ as cli
from tests.episodes import random_episode, write

STAGES = list(typer.main.get_command(cli.commands([])).commands)  # type: ignore[attr-defined]
HEAVY = {"torch", "lerobot", "pybullet", "numpy", "matplotlib", "datasets"}

DRIVES = {
    "--tracks": "alder",
    "--traffic": "2",
    "--seconds": "1",
    "--offset-spread": "0.3",
    "--angle-spread": "0.05",
    "--action-repeat": "2",
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


def test_the_list_of_commands_shows_each_with_a_whole_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["safedagger", "--help"])
    with pytest.raises(SystemExit):
        cli.main()
    lines = capsys.readouterr().out.split("Commands:\n")[1].splitlines()
    assert [line.split()[0] for line in lines] == STAGES
    assert all(line.endswith(".") and not line.endswith("...") for line in lines)
    assert all(line.count("(") == line.count(")") for line in lines)


def test_the_version_is_the_projects(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["safedagger", "--version"])
    with pytest.raises(SystemExit) as exit_:
        cli.main()
    assert exit_.value.code == 0
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    assert capsys.readouterr().out == f"safedagger {project['version']}\n"


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"--tracks": "nowhere"}, "nowhere"),
        ({"--traffic": "-1"}, "--traffic"),
        ({"--traffic": "9000"}, "9000"),
        ({"--seconds": "-3"}, "--seconds"),
        ({"--seconds": "nan"}, "seconds"),
        ({"--seconds": "0"}, "seconds is 0.0, expected a number above 0"),
        ({"--laps": "0"}, "laps is 0.0, expected a number above 0"),
        ({"--episodes": "0"}, "--episodes"),
        ({"--action-repeat": "7"}, "action_repeat"),
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


def test_why_drives_ended_is_said_of_a_dataset_and_of_its_episodes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from pipeline.data.dataset import Dataset
    from pipeline.inspection.excerpts import whole_episodes

    monkeypatch.chdir(tmp_path)
    typed = flat(COLLECT | {"--seconds": "0.2", "--episodes": "2"})
    monkeypatch.setattr(sys, "argv", ["safedagger", "collect", "D_0", *typed])
    with pytest.raises(SystemExit):
        cli.main()
    assert capsys.readouterr().out == (
        "D_0: 2 episodes, 6 frames, 6 queries; ended: out of time 2\n"
    )
    titles = [excerpt.title for excerpt in whole_episodes(Dataset.open(Path("D_0")))]
    assert all(title.endswith("; ended: out of time") for title in titles)


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
        ("select", "missing", "out"),
        ("contact-sheet", "missing", "out", "--frames", "3"),
        ("inspect", "missing"),
        ("compare", "missing", "missing"),
        ("sample", "missing", "out", "--frames", "3", "--seed", "0"),
        ("merge", "missing", "missing", "out"),
        ("ledger", "missing", "missing", "--metrics", "out"),
        (
            "cards",
            *("--datasets", "missing", "--models", "missing", "--metrics", "missing"),
            *("--action-repeat", "3"),
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


WRONG = """
import sys
from stages.__main__ import main
for command in sys.argv[1].splitlines():
    sys.argv[1:] = command.split()
    try:
        main()
    except SystemExit as end:
        assert end.code == 2
print(*{module.split(".")[0] for module in sys.modules})
"""


def test_a_wrong_path_is_found_out_before_anything_heavy_is_imported(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    drives = " ".join(flat(DRIVES))
    typed = (
        "select missing out",
        "merge there missing out",
        "inspect missing",
        "compare there missing",
        f"collect there {drives}",
        f"rollout there missing out --queries 1 --frames 1 {drives}",
        "watch missing --strategy naive --seed 0",
        "train-primary missing out",
        "train-primary there there",
        "train-safety there missing missing out",
        "evaluate missing --metrics m --drives d",
    )
    done = subprocess.run(
        [sys.executable, "-c", WRONG, "\n".join(typed)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    lines = done.stderr.splitlines()
    assert len(lines) == len(typed)
    assert all("'missing' does not exist" in line or " there: exists" in line for line in lines)
    assert not (HEAVY - {"numpy"} | {"pyarrow", "pandas", "scipy", "rerun"}) & set(
        done.stdout.split()
    )


def test_what_nobody_asked_is_selected_merged_and_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A rollout in which nothing was unsafe: the primary has become good, and all goes on."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    where = "drive on yew with 2 other cars"
    write(Path("D_0"), [random_episode(rng, 3, task=where, reference_only=True)])
    safe = random_episode(rng, 4, task=where, iteration=1)
    for name in ("intervention", "queried"):
        safe.columns[name][:] = False
    write(Path("rollout_1"), [safe], "rollout")
    steps = {
        ("select", "rollout_1", "new_1"): "new_1: 0 episodes, 0 frames, 0 queries",
        ("merge", "D_0", "new_1", "D_1"): "D_1: 1 episodes, 3 frames, 3 queries",
        (
            "ledger",
            "rollout_1",
            "D_1",
            "--metrics",
            "ledger.json",
        ): "ledger.json: 4 frames of 1 drives "
        "in 1 scenarios; 0 queries, 0 of them audits; 0 calls of the reference for 0 frames, 0 switches; "
        "0 frames selected, 3 trained on",
        ("inspect", "D_1", "--save", "D_1.rrd"): "D_1.rrd: open it with `rerun D_1.rrd`",
    }
    for command, last in steps.items():
        monkeypatch.setattr(sys, "argv", ["safedagger", *command])
        with pytest.raises(SystemExit) as exit_:
            cli.main()
        said = capsys.readouterr().out.splitlines()
        assert (exit_.value.code, said[-1]) == (0, last)
        if command[0] in ("select", "merge"):
            assert "nothing to" in said[-2]
    code, error = run(capsys, monkeypatch, "inspect", "new_1", "--save", "x.rrd")
    assert (code, error) == (2, "safedagger: new_1: has no frames, expected some to look at\n")


PRIMARY = {
    **{"--channels": "2", "--optimizer": "adamw", "--learning-rate": "0.001", "--batch": "4"},
    **{"--weight-decay": "0", "--samples": "4", "--validation": "0", "--patience": "1"},
    **{"--jitter": "0", "--steering-weight": "1", "--brake-weight": "1", "--brake-on": "1"},
    **{"--brake-cut": "0.5", "--seed": "0", "--threads": "1"},
}
SAFETY = {
    **{"--tau": "0.0025", "--horizon": "0", "--horizon-mode": "last", "--cut": "0.5"},
    **{"--balance": "1", "--held-out": "0.5", "--hidden": "4", "--optimizer": "adamw"},
    **{"--learning-rate": "0.001", "--weight-decay": "0", "--batch": "4", "--samples": "4"},
    **{"--validation": "0", "--patience": "1", "--seed": "0", "--threads": "1"},
}


def test_training_is_refused_what_would_spoil_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """No frame with a label; D_safe that was trained on; a safety policy of another primary."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    for name, number in (("D_0", 0), ("D_safe", 9)):
        episodes = [
            random_episode(rng, 3, episode=number + each, reference_only=True) for each in (0, 1)
        ]
        write(Path(name), episodes, name)
    unasked = random_episode(rng, 9, iteration=1)
    unasked.columns["queried"][:] = False
    write(Path("rollout"), [unasked], "rollout")

    train = ("train-primary", "D_0", "one", *flat(PRIMARY), "--no-mirror")
    assert run(capsys, monkeypatch, *train)[0] == 0
    other = (*train[:2], "other", *train[3:], "--seed", "1", "--curve", "curve.csv")
    assert run(capsys, monkeypatch, *other)[0] == 0
    assert re.fullmatch(r"epoch,samples,loss\n1,4,[0-9.]+\n", Path("curve.csv").read_text())
    code, error = run(capsys, monkeypatch, *train[:2], "third", *other[3:])
    assert (code, error.split(",")[0]) == (2, "safedagger: curve.csv: exists already")
    code, error = run(
        capsys, monkeypatch, "train-primary", "rollout", "bad", *flat(PRIMARY), "--no-mirror"
    )
    told = "of 9 frames none has a label of the reference, expected some to learn from"
    assert (code, error) == (2, f"safedagger: rollout: {told}\n")

    of_one = (*flat(SAFETY), "--measure", "steering", "--metrics", "m")
    code, error = run(capsys, monkeypatch, "train-safety", "one", "D_0", "D_0", "bad", *of_one)
    assert code == 2
    assert error == "safedagger: D_0: 6 of its frames are in D_0 too, expected none\n"
    assert run(capsys, monkeypatch, "train-safety", "one", "D_safe", "D_0", "safe", *of_one)[0] == 0
    watch = ("--tracks", "yew", "--traffic", "0", "--strategy", "safe", "--seconds", "0.2")
    drive = (*watch, "--action-repeat", "3", "--seed", "0", "--save", "drive.rrd")
    code, error = run(capsys, monkeypatch, "watch", "other", "safe", *drive)
    assert code == 2
    assert error == "safedagger: safe: was trained to watch another primary than other\n"
    assert not Path("bad").exists() and not Path("drive.rrd").exists()
    assert run(capsys, monkeypatch, "watch", "one", "safe", *drive)[0] == 0


def test_context_changes_no_training(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same frames are shown, held out and foreseen: of both policies, the same weights."""
    from pipeline.policies.loading import weights_sha256

    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    demonstrated = [random_episode(rng, 6, episode=n, reference_only=True) for n in (0, 1)]
    write(Path("D_safe"), demonstrated, "D_safe")
    drives = [random_episode(rng, 20, iteration=1, episode=n) for n in (0, 1)]
    write(Path("rollout"), drives, "rollout")
    trained = []
    for name, context in (("bare", []), ("around", ["--before", "0.1", "--after", "0.2"])):
        assert run(capsys, monkeypatch, "select", "rollout", name, *context)[0] == 0
        primary, safety = f"primary_{name}", f"safety_{name}"
        train = ("train-primary", name, primary, *flat(PRIMARY | {"--validation": "0.3"}))
        assert run(capsys, monkeypatch, *train, "--no-mirror")[0] == 0
        ahead = {"--horizon": "0.3", "--tau": "0.3", "--validation": "0.3"}
        train = ("train-safety", primary, "D_safe", name, safety, *flat(SAFETY | ahead))
        assert run(capsys, monkeypatch, *train)[0] == 0
        trained.append([weights_sha256(Path(policy)) for policy in (primary, safety)])
    assert trained[0] == trained[1]


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
from stages.__main__ import main
main()
"""


def test_a_fault_of_the_machine_is_one_line_and_leaves_nothing(tmp_path: Path) -> None:
    """As a full disk, which needs root to make: files that may not grow any further."""
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, "collect", str(tmp_path / "out"), *flat(COLLECT)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert re.fullmatch(r"safedagger: .*File too large\n", done.stderr)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--drives", "--metrics"])
@pytest.mark.parametrize("place", ["/proc/x.csv", "n" * 300])
def test_a_place_that_cannot_be_written_is_found_out_before_the_driving(
    option: str,
    place: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The policies are no policies, too: nobody opens them yet."""
    monkeypatch.chdir(tmp_path)
    Path("policy").mkdir()
    drives = {k: v for k, v in DRIVES.items() if "spread" not in k}
    places = {"--drives": "drives.csv", "--metrics": "metrics.json"} | {option: place}
    typed = drives | places | {"--laps": "1", "--starts": "1", "--strategies": "naive"}
    code, error = run(capsys, monkeypatch, "evaluate", "policy", "policy", *flat(typed))
    assert code == 2
    assert error.startswith(f"safedagger: {place}: ")
    assert len(error.splitlines()) == 1
    assert list(tmp_path.iterdir()) == [tmp_path / "policy"]


def test_the_cut_of_a_rollout_is_its_safety_policys_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is said once, where the policy is trained; a rollout may be told another, and keeps it.

    What deviates is the primary's, if nobody says; and without a place for metrics, none is written.
    """
    from pipeline.data.dataset import Dataset

    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    for name in ("D_0", "D_safe"):
        episodes = [random_episode(rng, 3, episode=n, reference_only=True) for n in (0, 1)]
        write(Path(name), episodes, name)
    train = ("train-primary", "D_0", "primary", *flat(PRIMARY), "--no-mirror")
    assert run(capsys, monkeypatch, *train)[0] == 0
    safety = flat(SAFETY | {"--cut": "1"})
    train = ("train-safety", "primary", "D_safe", "D_0", "safety", *safety)
    assert run(capsys, monkeypatch, *train)[0] == 0
    budget = {"--queries": "99", "--frames": "10", "--iteration": "1"}
    for name, cut, drove in (("own", [], 10), ("told", ["--cut", "0"], 0)):
        typed = flat(DRIVES | budget)
        rollout = ("rollout", "primary", "safety", name, *typed, *cut)
        assert run(capsys, monkeypatch, *rollout)[0] == 0
        driven = Dataset.open(Path(name))
        assert driven.lineage.own.arguments["cut"] == (1 if name == "own" else 0)
        labels = driven.lineage.own.arguments["labels"]
        assert (labels["tau"], labels["measure"]) == (0.0025, "steering-and-brake")
        trained = driven.lineage.parents[1].own.arguments
        assert (trained["cut"], trained["measure"]) == (1, "steering-and-brake")
        assert [parent.own.purpose for parent in driven.lineage.parents] == ["primary", "safety"]
        assert int(driven.column("intervention").sum()) == drove
        assert run(capsys, monkeypatch, "select", name, f"new_{name}")[0] == 0
        assert len(Dataset.open(Path(f"new_{name}"))) == drove
    assert not list(tmp_path.glob("*.json"))


def test_the_settings_of_a_task_are_options_of_the_commands_that_drive(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the car by default; of whatever task is named otherwise."""
    for task, expected in (
        ([], "--offset-spread"),
        (["--task", "driving"], "--offset-spread"),
        (["--task", "tests.stages.pendulum:Pendulum"], "--length"),
    ):
        monkeypatch.setattr(sys, "argv", ["safedagger", "collect", *task, "--help"])
        with pytest.raises(SystemExit):
            cli.main()
        shown = capsys.readouterr().out
        assert expected in shown and "--episodes" in shown
        assert ("--tracks" in shown) == (expected == "--offset-spread")


@pytest.mark.parametrize("task", ["nowhere", "json:dumps", "tests.stages.pendulum:Nothing"])
def test_a_task_that_there_is_not_is_named_in_one_line(
    task: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    code, error = run(capsys, monkeypatch, "collect", "out", "--task", task)
    assert code == 2
    assert len(error.splitlines()) == 1
    assert error.startswith(f"safedagger: task {task!r}") and "expected" in error

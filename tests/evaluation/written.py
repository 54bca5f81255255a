"""What the commands leave of an experiment, in files."""

from pathlib import Path
from typing import Any

from pipeline.evaluation.drives import read_drives, write_drives
from pipeline.evaluation.experiment import D_SAFE, STEP, Experiment
from pipeline.evaluation.writing import write_metrics, write_rows
from pipeline.metric import QUALITY, SPENT
from pipeline.output import write_file
from tests.evaluation.made_up import COMPARISON, GROWING, TRACKS, experiment

CONDITIONS = [
    {"condition": name, "name": "driving", "laps": 3.0, "tracks": ",".join(TRACKS)}
    for name in ("no_traffic", "traffic")
]
ERRORS = {"trained_on": {"share_safe": 0.95}, "tau": 0.0025, "share": 0.777}
ERRORS |= {"held_out": {"share_safe": 0.8, "tau_for_share": 0.0018}}


def quality(auroc: float) -> dict[str, Any]:
    return {
        "tau": 0.0025,
        "frames": 40,
        "auroc": auroc,
        "recall": auroc - 0.3,
        "precision": auroc - 0.2,
        "share_unsafe": 0.2,
        "share_predicted_unsafe": 0.15,
        "average_precision": auroc,
        "calibration_error": 0.1,
        "calibration": [[0.1, 0.15, 30], [0.6, 0.7, 10]],
    }


def write(made_up: Experiment, metrics: Path) -> Path:
    """Every file that the report reads of each seed; safety policies, of which a made-up experiment
    knows nothing, are the worse the later. Gives the last seed's folder.
    """
    for seed in made_up.seeds:
        folder, one = metrics / f"seed_{seed}", made_up.of_seeds(seed)
        write_file(folder / "runs.json", COMPARISON.model_dump_json(exclude_defaults=True).encode())
        write_metrics(folder / "errors.json", ERRORS)
        for (step, iteration), driven in one.drives.groupby(["step", "iteration"]):
            first = driven[driven.run == driven.run.iloc[0]]  # of those that share iteration 0
            write_drives(folder / f"drives_{step}.csv", first.drop(columns=[*STEP, "task.laps"]))
            write_metrics(folder / f"driving_{step}.json", {"rows": CONDITIONS})
            write_rows(folder / f"safety_{step}.json", quality(0.9 - iteration / 50), QUALITY)
            if made_up.specs[first.run.iloc[0]].is_watched and iteration:
                rollout = quality(0.8 - iteration / 50)
                write_rows(folder / f"rollout_{step}.json", rollout, QUALITY)
        for ledger in one.ledgers.drop_duplicates("step").to_dict("records"):
            step = "safe" if ledger["step"] == D_SAFE else ledger["step"]
            counted = {name: value for name, value in ledger.items() if name not in STEP}
            write_rows(folder / f"ledger_D_{step}.json", counted, SPENT)
    return folder


def write_run(metrics: Path, seeds: int = 1) -> Path:
    """That of SafeDAgger alone; gives the last seed's folder."""
    return write(experiment({"safedagger": GROWING}, seeds, starts=2), metrics)


def write_beside(folder: Path, name: str, tau: float = 0.0025, iteration: int = 1) -> None:
    """Another policy in a seed's folder, driven as those of an iteration of SafeDAgger."""
    for kind in ("drives_{}.csv", "driving_{}.json", "safety_{}.json"):
        text = (folder / kind.format(f"safedagger_{iteration}")).read_text()
        (folder / kind.format(name)).write_text(text.replace('"tau": 0.0025', f'"tau": {tau}'))


def drive_again(file: Path, **changes: Any) -> None:
    """Other values in all of the drives of a file."""
    driven = read_drives(file).assign(**changes)
    file.unlink()
    write_drives(file, driven)

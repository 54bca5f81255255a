"""What docs/safety-policy.md and the README say of three seeds is what `scales/study` has found, in
cards/study, and the label curves, in cards/curves.
"""

import json
from collections.abc import Callable
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np
import pytest

from pipeline.driving.metrics import METRICS
from pipeline.evaluation.drives import column
from pipeline.evaluation.reading import read_reliability

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "safety-policy.md").read_text()
SEEDS = sorted((ROOT / "cards" / "study").glob("seed_*"))
CURVES = sorted((ROOT / "cards" / "curves").glob("seed_*"))
PRIMARIES = ("pi_0", "pi_1")
KINDS = {
    "0_paper": "none, as the paper",
    "0_size": "`--learns size --cut 0.7`",
    "0_size_calibrated": "the same, `--calibration 0.2`",
    "0_some": "`--audits`, 1,000",
    "0_own": "`--audits`, 8,000",
    "0_own_calibrated": "the same, `--calibration 0.2`",
    "0_own_size": "`--audits`, 8,000, `--learns size --cut 0.7`",
    "1_paper": "none, as the paper",
    "1_size": "`--learns size --cut 0.7`",
    "1_carried": "`--audits`, 8,000 of pi_0's rollout",
    "1_own": "`--audits`, 8,000 of its own",
}

LOOPS = {
    "audited2000": ("with audits", "unsafe, 0.5"),
    "safedagger2000": ("as in the paper", "unsafe, 0.5"),
    "sized2000": ("that learns how far", "size, 0.7"),
    "seldom2000": ("that asks seldom", "unsafe, 0.3"),
    "quarter2000": ("that asks seldom, a quarter of D_safe", "unsafe, 0.3"),
}

SPREAD = {
    "quarter1000": "SafeDAgger that asks seldom, a quarter of D_safe",
    "quarter2000": "the same",
    "seldom2000": "SafeDAgger that asks seldom",
    "dagger_seldom2000": "DAgger that asks seldom",
    "dagger1000": "DAgger",
    "dagger2000": "DAgger",
    "dagger4000": "DAgger",
}


def _found(name: str) -> list[dict[str, Any]]:
    return [json.loads((seed / f"{name}.json").read_text()) for seed in SEEDS]


def _all(name: str, key: str) -> list[float]:
    return [seed["rows"][0][key] for seed in _found(name)]


def _share(numbers: list[float]) -> str:
    return f"{100 * mean(numbers):.0f} %"


def _mean(numbers: list[float]) -> str:
    return f"{mean(numbers):.2f}"


def _each(numbers: list[float]) -> str:
    return ", ".join(f"{number:.2f}" for number in numbers)


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _situations() -> list[str]:
    rows = []
    for number, row in enumerate(_found("0_paper")[0]["rows"]):
        of = [[seed["rows"][number] for seed in _found(f"{i}_paper")] for i in (0, 1)]
        whole = [[seed["rows"][0]["frames"] for seed in _found(f"{i}_paper")] for i in (0, 1)]

        def both(key: str, told: Callable[[list[float]], str], of: Any = of) -> str:
            return " / ".join(told([seed[key] for seed in seeds]) for seeds in of)

        shares = (
            [seed["frames"] / frames for seed, frames in zip(seeds, all_frames, strict=True)]
            for seeds, all_frames in zip(of, whole, strict=True)
        )
        rows.append(
            _row(
                "all" if row["situation"] == "all" else f"`{row['situation']}`",
                " / ".join(map(_share, shares)),
                both("share_unsafe", _share),
                *(_each([seed["auroc"] for seed in seeds]) for seeds in of),
                both("calibration_error", _mean),
            )
        )
    return rows


def _bounds() -> list[str]:
    errors = [bound["error"] for bound in _found("0_paper")[0]["bounds"]]
    return [_row("error of the steering", *map(str, errors))] + [
        _row(
            name,
            *(
                _mean([seed["bounds"][number]["auroc"] for seed in _found(f"{i}_paper")])
                for number in range(len(errors))
            ),
        )
        for i, name in enumerate(PRIMARIES)
    ]


def _kinds() -> list[str]:
    return [
        _row(
            words,
            *(_share(_all(name, key)) for key in ("share_predicted_unsafe", "recall", "precision")),
            _each(_all(name, "auroc")),
            _mean(_all(name, "average_precision")),
            _mean(_all(f"{name}_large", "auroc")),
            _mean(_all(name, "calibration_error")),
        )
        for name, words in KINDS.items()
    ]


def _of_loop(kind: str, run: str, key: str) -> list[list[float]]:
    """By iteration, then by seed."""
    files = [[seed / f"{kind}_{run}_{i}.json" for seed in CURVES] for i in (1, 2, 3)]
    return [[json.loads(file.read_text())["rows"][0][key] for file in of] for of in files]


def _loops() -> list[str]:
    curves, rows = read_reliability(ROOT / "cards" / "curves"), []
    for run, words in LOOPS.items():
        shares = (
            f"{', '.join(f'{100 * mean(of):.0f}' for of in _of_loop('rollout', run, key))} %"
            for key in ("share_predicted_unsafe", "precision")
        )
        driven, calls, failures = (
            np.sum(_of_loop("ledger_D", run, key), axis=0)
            for key in ("frames_driven", "calls", "failures")
        )
        ends = column(curves.among(run=run, iteration=3), METRICS["success"].part)
        success, broke = f"{100 * ends.mean():.1f} %", ", ".join(map(str, failures))
        rows.append(
            _row(*words, f"{driven.mean():,.0f}", *shares, f"{calls.mean():.0f}", success, broke)
        )
    return rows


def _spread() -> list[str]:
    """What comes of it, beside DAgger."""
    curves, rows = read_reliability(ROOT / "cards" / "curves"), []
    for run, words in SPREAD.items():
        spent = curves.spent[(curves.spent.run == run) & (curves.spent.iteration == 3)]
        ends = column(curves.among(run=run, iteration=3), METRICS["success"].part)
        broke = ", ".join(f"{failures:.0f}" for failures in spent.failures)
        means = (f"{spent[name].mean():,.0f}" for name in ("queries", "labels", "frames_driven"))
        rows.append(_row(words, *means, f"{100 * ends.mean():.1f} %", broke))
    return rows


@pytest.mark.parametrize("row", [*_situations(), *_bounds(), *_kinds(), *_loops(), *_spread()])
def test_the_page_has_what_was_measured(row: str) -> None:
    assert row in PAGE


def test_the_readme_begins_with_what_was_measured() -> None:
    curves = read_reliability(ROOT / "cards" / "curves")

    def of(run: str) -> dict[str, float]:
        ends = column(curves.among(run=run, iteration=3), METRICS["success"].part)
        spent = curves.spent[(curves.spent.run == run) & (curves.spent.iteration == 3)]
        told = {name: spent[name].mean() for name in ("labels", "frames_driven")}
        return {"success": 100 * ends.mean(), "failures": spent.failures.sum(), **told}

    ours, fewer, control, most = map(
        of, ("quarter2000", "quarter1000", "dagger_seldom2000", "dagger4000")
    )
    text = " ".join((ROOT / "README.md").read_text().partition("On Linux")[0].split())
    assert ours["success"] == 100
    for said in (
        f"all of {len(curves.among(run='quarter2000', iteration=3))} laps",
        f"with 1,000 {fewer['success']:.1f} %",
        f"{of('dagger2000')['success']:.1f} % and {of('dagger1000')['success']:.1f} %, and "
        f"{most['success']:.1f} % with 4,000",
        f"{ours['labels']:,.0f} labels against DAgger's {most['labels']:,.0f}",
        f"did {control['success']:.1f} % with 2,000 labels, {control['labels']:,.0f} in all",
        f"it failed {control['failures']:.0f} times",
        f"seldom {ours['failures']:.0f} times, in more frames",
        f"({of('sized2000')['failures']:.0f} times with one",
        f"failed {most['failures']:.0f} times with 4,000 labels",
    ):
        assert said in text
    assert ours["frames_driven"] > control["frames_driven"] > 5 * most["frames_driven"]
    assert of("seldom2000")["failures"] == of("safedagger2000")["failures"] == 0


def test_nothing_that_was_measured_is_left_out() -> None:
    for seed in SEEDS:
        files = {file.stem for file in seed.glob("[01]_*.json")}
        assert files == {name + end for name in KINDS for end in ("", "_large")}

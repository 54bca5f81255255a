"""The card of a dataset: what it is, what made it, what is in it, and what it does not hold."""

from collections.abc import Mapping, Sequence
from typing import Any

from huggingface_hub import DatasetCard, DatasetCardData

from pipeline.cards.facts import Count, Facts
from pipeline.cards.origin import shown
from pipeline.cards.purposes import PROJECT, purpose
from pipeline.cards.strip import sample_rows
from pipeline.data.lineage import Made
from pipeline.driving.features import CONTROL_HZ, FEATURES
from pipeline.evaluation.wording import count, share, table

MEANINGS = {
    "observation.images.front": "the camera, 160 x 72 RGB, lossless",
    "action": "steering [-1, 1] and brake {0, 1}: the reference's where it was asked, else the "
    "primary's",
    "primary_action": "what the primary proposed",
    "affordances": "the ten hidden variables of the paper's Appendix A",
    "vehicle_state": "the car's position [m], heading [rad] and speed [m/s]: to look at, no policy "
    "sees it",
    "intervention": "the reference drove",
    "queried": "the frame cost a query",
    "safe_probability": "the safety policy's; below the cut is unsafe",
    "deviation": "squared difference of the two steerings (the brakes are not in it), where both are known",
    "asked_because": "why the reference was asked: 0 it drove, 1 an audit, 2 DAgger's mixture, 3 "
    "afterwards; -1 it was not",
    "ask_probability": "with which probability it was asked; 1 where it drove",
    "source.dataset": "the dataset in which the frame was first recorded: the first 63 bits of its "
    "sha256 in `safedagger.json`",
    "source.iteration": "the iteration in which the frame was first recorded",
    "source.episode": "the drive of that iteration",
    "source.frame": "the frame of that drive",
}
"""Of every column."""

_SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (10**6, "100K<n<1M"))


def render_dataset_card(
    facts: Facts,
    *,
    place: str,
    picture: str | None,
    made: Made,
    parents: Sequence[str],
) -> str:
    """The card as markdown with the front matter of a dataset on the Hub.

    Args:
        facts: the dataset's.
        place: its path, from where the project is.
        picture: where the strip of its sample frames is, as seen from the card; None without frames.
        made: how it was made.
        parents: what that was made from, in markdown.
    """
    return str(
        DatasetCard(
            f"""---
{_front_matter(facts).to_yaml()}
---

# {facts.name}

{purpose(made)} {PROJECT}

{_frames(facts, picture)}

{_size(facts)}

## Where it comes from

{_lineage(made, parents)}

## What is in it

{_counts("scenario", facts.scenarios)}

{_counts("first recorded in iteration", facts.iterations)}

## Columns

{_columns(facts)}

## Limits

{_limits(facts)}

## Load it

```python
from lerobot.datasets import LeRobotDataset

dataset = LeRobotDataset("local/{facts.name}", root="{place}", video_backend="pyav")
```
"""
        )
    )


def _front_matter(facts: Facts) -> DatasetCardData:
    """As LeRobot's own card has it, and the size. There is no license to name."""
    return DatasetCardData(
        pretty_name=facts.name,
        tags=["LeRobot", "safedagger"],
        task_categories=["robotics"],
        size_categories=[
            next((name for most, name in _SIZES if facts.total.frames < most), "1M<n<10M")
        ],
        configs=[{"config_name": "default", "data_files": "data/*/*.parquet"}],
    )


def _frames(facts: Facts, picture: str | None) -> str:
    if picture is None:
        return "It has no frames: nothing was asked."
    sampled = len(sample_rows(facts.total.frames))
    return f"![Sample frames of {facts.name}]({picture})\n\n{sampled} of its frames, evenly spaced."


def _size(facts: Facts) -> str:
    total = facts.total
    judged, known = facts.judged, facts.compared
    seconds = total.frames * facts.action_repeat / CONTROL_HZ
    return table(
        ["", "in all", "share"],
        [
            ["episodes", count(total.episodes), ""],
            ["frames", count(total.frames), ""],
            ["frames per second", f"{CONTROL_HZ // facts.action_repeat}", ""],
            [f"control steps (1/{CONTROL_HZ} s) in a frame", f"{facts.action_repeat}", ""],
            ["driving time [s]", f"{seconds:,.1f}", ""],
            ["queries", *_part(total.queries, total.frames)],
            ["frames that the reference drove", *_part(total.by_reference, total.frames)],
            ["frames that brake", *_part(facts.braking, total.frames)],
            *_spread("from the middle of the lane, at most [m]", facts.offset),
            *_spread("angle to the lane, at most [rad]", facts.angle),
            ["frames that a safety policy judged", *_part(judged, total.frames)],
            *([["of these, called unsafe", *_part(facts.called_unsafe, judged)]] if judged else []),
            *(
                [
                    ["of a safety policy's, both actions known", *_part(known, total.frames)],
                    [
                        f"of these, unsafe: {' or '.join(facts.unsafe_is)}",
                        *_part(facts.deviating, known),
                    ],
                ]
                if known
                else []
            ),
            *([f"drives: {ended}", count(drives), ""] for ended, drives in facts.endings.items()),
        ],
    )


def _spread(what: str, within: tuple[float, float] | None) -> list[list[str]]:
    if within is None:
        return []
    half, most = within
    return [[what, f"{half:.2f}", "50 %"], [what, f"{most:.2f}", "95 %"]]


def _lineage(made: Made, parents: Sequence[str]) -> str:
    if made.purpose == "foreign":
        return "Not known: there is no `safedagger.json` that says what made it."
    made_from = f"Made from {', '.join(parents)}." if parents else "Made from no other dataset."
    return f"{made_from} {shown(made)}"


def _counts(what: str, counts: Mapping[Any, Count]) -> str:
    return table(
        [what, "episodes", "frames", "queries", "frames that the reference drove"],
        [
            [str(key), *map(count, (of.episodes, of.frames, of.queries, of.by_reference))]
            for key, of in counts.items()
        ],
    )


def _columns(facts: Facts) -> str:
    return table(
        ["column", "meaning", "type", "shape", "frames without a value (NaN)"],
        [
            [
                f"`{name}`",
                MEANINGS[name],
                feature["dtype"],
                " x ".join(map(str, feature["shape"])),
                count(facts.unknown.get(name, 0)),
            ]
            for name, feature in FEATURES.items()
        ],
        words=4,
    )


def _limits(facts: Facts) -> str:
    total = facts.total
    unasked = total.frames - total.queries
    found = ["Simulated: the pictures have a renderer's looks, and no noise of a sensor."]
    if unasked:
        found.append(
            f"In {count(unasked)} of {count(total.frames)} frames nobody asked the reference: "
            "`action` there is what the primary did, and no label to imitate."
        )
    else:
        found.append("`action` is the reference's in every frame.")
    missing = {name: frames for name, frames in facts.unknown.items() if frames}
    if missing:
        of_each = ", ".join(f"`{name}` in {count(frames)}" for name, frames in missing.items())
        found.append(f"NaN stands where there is no value: {of_each} frames.")
    if facts.cut_out:
        found.append(
            f"{count(facts.cut_out)} of {count(total.episodes)} episodes begin within a drive: what "
            "happened before is not here."
        )
    if facts.single:
        found.append(
            f"{count(facts.single)} of {count(total.episodes)} episodes are a single frame: nothing "
            "that looks ahead or back in time can use them."
        )
    return "\n".join(f"- {limit}" for limit in found)


def _part(part: int, whole: int) -> tuple[str, str]:
    return count(part), share(part / whole) if whole else ""

import json
import re
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from pipeline.data.dataset import Dataset
from pipeline.data.ledger import collected, count
from pipeline.data.merging import merge
from pipeline.data.schema import Asked, Episode
from pipeline.data.selecting import sample, select
from tests.episodes import random_episode, write

COST = ("frames_driven", "queries", "frames_selected", "frames_trained", "takeover")


def cost(raw: Dataset, aggregate: Dataset) -> tuple[int | float | None, ...]:
    counted = count(raw, aggregate)
    return tuple(counted[name] for name in COST)


def test_iteration_zero_is_what_the_reference_drove(d_0: Dataset) -> None:
    assert cost(d_0, d_0) == (7, 7, 7, 7, 1.0)


def test_dagger_pays_for_labels_that_it_throws_away(d_0: Dataset, tmp_path: Path) -> None:
    # all ten rows labelled while the primary drives, of which five are kept
    drive = random_episode(np.random.default_rng(0), 10, asked=[Asked.MIXTURE] * 10)
    driven = write(tmp_path / "raw", [drive])
    sample(driven, tmp_path / "selected", 5, seed=0)
    merge([d_0, Dataset.open(tmp_path / "selected")], tmp_path / "D_1")
    assert cost(driven, Dataset.open(tmp_path / "D_1")) == (10, 10, 5, 12, 0.0)
    assert collected(driven) | {"drives": 1, "calls": 0, "switches": 0} == collected(driven)


@settings(
    max_examples=3,
    deadline=None,
    phases=[Phase.generate],  # shrinking would take minutes
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(lengths=st.lists(st.integers(1, 6), min_size=1, max_size=2), seed=st.integers(0, 2**32 - 1))
def test_safedagger_neither_loses_nor_invents_a_frame(
    d_0: Dataset, lengths: list[int], seed: int
) -> None:
    # the rows selected are the rows queried, and what the aggregate grew by
    rng = np.random.default_rng(seed)
    raw = [random_episode(rng, n, iteration=1, episode=e) for e, n in enumerate(lengths)]
    unsafe = sum(int(drive.columns["intervention"].sum()) for drive in raw)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        driven = write(root / "raw", raw)
        kept = select(driven, root / "selected")
        merged = merge([d_0, Dataset.open(root / "selected")], root / "D_1")
        ledger = cost(driven, Dataset.open(root / "D_1"))
        queried = driven.column("queried")

    assert kept.frames == queried.sum() == unsafe
    assert merged.frames == 7 + kept.frames
    assert ledger == (sum(lengths), unsafe, unsafe, 7 + unsafe, unsafe / sum(lengths))
    assert kept.queries == unsafe


def test_a_ledger_is_plain_numbers(d_0: Dataset) -> None:
    numbers = count(d_0, d_0)
    assert json.loads(json.dumps(numbers)) == numbers
    kinds = [type(number) for number in numbers.values() if number is not None]
    assert kinds == [int] * 4 + [float] + [int] * 6


def test_a_rollout_in_which_nothing_was_asked_cost_nothing(
    d_0: Dataset, unasked: Dataset, nothing: Dataset, tmp_path: Path
) -> None:
    merge([d_0, nothing], tmp_path / "D_1")
    assert cost(unasked, Dataset.open(tmp_path / "D_1")) == (4, 0, 0, 7, 0.0)
    assert cost(nothing, d_0) == (0, 0, 0, 7, 0.0)
    assert {each for each in collected(nothing).values() if each is not None} == {0}


DRIVES = st.lists(
    st.tuples(
        st.lists(st.sampled_from([Asked.NOT, Asked.DROVE, Asked.AUDIT]), min_size=1, max_size=6),
        st.sampled_from(["alder", "birch"]),
        st.integers(0, 3),
        st.sampled_from(["road left", "stood still", "laps done"]),
    ),
    min_size=2,
    max_size=4,
)


def drive(asked: list[Asked], track: str, touches: int, ended: str) -> Episode:
    """Of the car, as it is recorded."""
    episode = random_episode(np.random.default_rng(0), len(asked), task=track, asked=asked)
    told = {"touches": float(touches), "off_road": float(ended == "road left"), "ended": ended}
    return replace(episode, ending=told | {"put_back": int(ended != "laps done")})


@settings(max_examples=5, deadline=None, phases=[Phase.generate])
@given(drives=DRIVES, cut=st.integers(1, 3))
def test_what_collecting_took_is_the_sum_over_its_drives(
    drives: list[tuple[list[Asked], str, int, str]], cut: int
) -> None:
    """However they are parted into datasets, but for the scenarios that both parts have."""
    with tempfile.TemporaryDirectory() as folder:
        whole, *parts = (
            collected(write(Path(folder, name), [drive(*each) for each in some], task="driving"))
            for name, some in (("whole", drives), ("first", drives[:cut]), ("rest", drives[cut:]))
            if some
        )
    assert whole.pop("scenarios") == len({track for _, track, _, _ in drives})
    assert whole == {name: sum(part[name] for part in parts) for name in whole}
    assert whole["drives"] == len(drives)
    # by another way: each drive as a word of its drivers
    words = ["".join("r" if asked is Asked.DROVE else "p" for asked in each[0]) for each in drives]
    assert whole["calls"] == sum(len(re.findall("r+", word)) for word in words)
    assert whole["switches"] == sum(len(re.findall("(?=rp|pr)", word)) for word in words)
    assert whole["frames_of_calls"] == "".join(words).count("r")
    assert whole["calls"] <= whole["frames_of_calls"]
    assert whole["switches"] <= 2 * whole["calls"]
    assert whole["audits"] == sum(each[0].count(Asked.AUDIT) for each in drives)
    ends = [ended for _, _, _, ended in drives]
    assert whole["failures.road_left"] == ends.count("road left")
    assert whole["failures.stood_still"] == ends.count("stood still")
    assert whole["failures.touches"] == sum(touches for _, _, touches, _ in drives)
    assert whole["failures"] == len(ends) - ends.count("laps done") + whole["failures.touches"]
    assert whole["put_back"] == len(ends) - ends.count("laps done")


def test_what_nobody_wrote_down_is_unknown(tmp_path: Path) -> None:
    """How drives ended, what was driven, or what an older table of drives lacks."""
    ended = drive([Asked.DROVE], "alder", 2, "road left")
    old = {name: value for name, value in (ended.ending or {}).items() if name != "touches"}
    kinds = ("failures.road_left", "failures.touches", "failures.stood_still")

    def told(name: str, episode: Episode, **arguments: str) -> list[int | None]:
        found = collected(write(tmp_path / name, [episode], **arguments))
        return [found.get(each) for each in ("put_back", "failures", *kinds)]

    assert told("all", ended, task="driving") == [1, 3, 1, 2, 0]
    assert told("older", replace(ended, ending=old), task="driving") == [1, None, 1, None, 0]
    assert told("unnamed", ended) == [1, None, None, None, None]
    assert told("open", replace(ended, ending=None), task="driving") == [None] * 5
    with pytest.raises(ValueError, match="task 'nothing': expected one of driving"):
        told("strange", ended, task="nothing")

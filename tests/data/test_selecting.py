from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.data.blocks import GROUP, row_groups
from pipeline.data.dataset import Dataset
from pipeline.data.images import read_episodes
from pipeline.data.ledger import count
from pipeline.data.merging import merge
from pipeline.data.pieces import chosen, runs
from pipeline.data.schema import Asked, Episode
from pipeline.data.selecting import sample, select, split
from pipeline.data.stored import pngs
from pipeline.driving.features import CAMERA, FEATURES
from tests.data.spoiling import copy, drop_column, set_last_image
from tests.episodes import random_episode, write
from tests.files import tree


@given(st.lists(st.booleans(), max_size=40))
def test_runs_cover_the_chosen_rows_and_are_as_long_as_can_be(rows: list[bool]) -> None:
    found = runs(np.array(rows, bool))
    covered = [row for run in found for row in range(run.start, run.stop)]
    assert covered == np.flatnonzero(rows).tolist()
    assert all(run.start < run.stop for run in found)
    assert all(a.stop < b.start for a, b in pairwise(found))


def test_no_piece_reaches_over_the_end_of_an_episode(rollout_1: Dataset) -> None:
    everything = chosen(rollout_1, np.ones(len(rollout_1), bool))
    assert [(piece.start, piece.stop) for piece in everything] == rollout_1.bounds


def test_selection_keeps_what_was_asked_as_it_was(
    rollout_1: Dataset, drives: list[Episode], tmp_path: Path
) -> None:
    summary = select(rollout_1, tmp_path / "new")
    asked = int(rollout_1.column("queried").sum())
    assert (summary.frames, summary.queries) == (asked, asked)
    new = Dataset.open(tmp_path / "new")
    for _, run in read_episodes(new):
        frames = run.columns["source.frame"][:, 0]
        assert (np.diff(frames) == 1).all(), "an episode has a gap in time"
        origin = drives[run.columns["source.episode"][0, 0]]
        assert run.task == origin.task
        for name in FEATURES.keys() - {"source.dataset"}:
            rows = origin.columns[name][frames[0] : frames[-1] + 1]
            np.testing.assert_array_equal(run.columns[name], rows)
    assert set(new.column("source.dataset").tolist()) == {rollout_1.lineage.id}


def test_what_was_audited_is_selected_apart(tmp_path: Path) -> None:
    """A label that was paid for, though the primary drove: no D_i has it."""
    drive = random_episode(np.random.default_rng(0), 8, asked=[-1, 0, 1, -1, 1, -1, 0, 2])
    rollout = write(tmp_path / "rollout", [drive])
    for because, frames in ((Asked.DROVE, [1, 6]), (Asked.AUDIT, [2, 4]), (Asked.MIXTURE, [7])):
        select(rollout, tmp_path / because.name, because)
        new = Dataset.open(tmp_path / because.name)
        assert new.column("source.frame").tolist() == frames
        assert new.column("queried").all()
    assert new.lineage.own.arguments == {"because": "mixture"}


def test_context_is_kept_as_it_was_and_joins_what_overlaps(tmp_path: Path) -> None:
    """At 10 frames per second, 0.2 s before and 0.1 s after, within an episode."""
    reasons = [np.where(np.isin(range(10), of), 0, -1) for of in ((0, 5, 6, 9), (3,))]
    rng = np.random.default_rng(0)
    drives = [random_episode(rng, 10, episode=n, asked=of) for n, of in enumerate(reasons)]
    rollout = write(tmp_path / "rollout", drives)
    summary = select(rollout, tmp_path / "new", before=0.2, after=0.1)
    assert (summary.episodes, summary.frames, summary.queries) == (3, 2 + 7 + 4, 5)
    new = Dataset.open(tmp_path / "new")
    assert new.lineage.own.arguments == {"before": 0.2, "after": 0.1}
    kept = new.columns(["source.frame", "queried", "asked_because"])
    assert kept["source.frame"][:, 0].tolist() == [0, 1, *range(3, 10), *range(1, 5)]
    assert new.lengths.tolist() == [2, 7, 4]
    np.testing.assert_array_equal(kept["queried"], kept["asked_because"] == Asked.DROVE)
    rows = 10 * new.column("source.episode") + new.column("source.frame")
    for name in ("action", "primary_action", "queried", "intervention"):
        np.testing.assert_array_equal(
            new.columns([name])[name], rollout.columns([name])[name][rows]
        )


def test_context_costs_nothing_and_is_merged_as_context(
    d_0: Dataset, rollout_1: Dataset, tmp_path: Path
) -> None:
    ledgers = []
    for seconds in (0, 0.1):
        new, merged = (tmp_path / f"{name}_{seconds}" for name in ("new", "D_1"))
        select(rollout_1, new, before=seconds, after=seconds)
        merge([d_0, Dataset.open(new)], merged)
        ledgers.append(count(rollout_1, Dataset.open(merged)))
    asked = rollout_1.column("queried").sum()
    assert ledgers[0] == ledgers[1]
    assert ledgers[0]["queries"] == ledgers[0]["frames_selected"] == asked
    both = Dataset.open(merged)
    assert len(both) > len(d_0) + asked == both.column("queried").sum()


def test_without_context_the_bytes_are_the_same(rollout_1: Dataset, tmp_path: Path) -> None:
    select(rollout_1, tmp_path / "new")
    select(rollout_1, tmp_path / "too", before=0.0, after=0)
    assert tree(tmp_path / "new") == tree(tmp_path / "too")


@pytest.mark.parametrize("seconds", [-0.1, np.nan, np.inf])
def test_context_is_a_time(rollout_1: Dataset, tmp_path: Path, seconds: float) -> None:
    for name in ("before", "after"):
        with pytest.raises(ValueError, match=f"^{name} is {seconds}, expected seconds, 0 or more"):
            select(rollout_1, tmp_path / "new", **{name: seconds})
    assert list(tmp_path.iterdir()) == []


def test_pictures_pass_through_unseen(rollout_1: Dataset, tmp_path: Path) -> None:
    """Neither decoded nor encoded: one that is no picture at all passes, too."""
    other = copy(rollout_1, tmp_path / "other")
    set_last_image(b"no PNG")(other)
    sample(Dataset.open(other), tmp_path / "new", 7, seed=3)
    new = Dataset.open(tmp_path / "new")
    before, after = (
        [png for table in d.tables(d.bounds, [CAMERA]) for png in pngs(table[CAMERA])]
        for d in (Dataset.open(other), new)
    )
    places = zip(new.column("source.episode"), new.column("source.frame"), strict=True)
    starts = [start for start, _ in rollout_1.bounds]
    assert after == [before[starts[episode] + frame] for episode, frame in places]
    assert after[-1] == b"no PNG"


def test_of_a_part_the_pictures_statistics_are_those_of_its_episode(
    rollout_1: Dataset, new_1: Dataset
) -> None:
    before, after = (pq.read_table(d.episode_files[0]) for d in (rollout_1, new_1))
    kept = [int(new_1.column("source.episode")[start]) for start, _ in new_1.bounds]
    for key in ("mean", "max", "q50"):
        of_episodes = before[f"stats/{CAMERA}/{key}"].to_pylist()
        assert after[f"stats/{CAMERA}/{key}"].to_pylist() == [of_episodes[e] for e in kept]
    assert after[f"stats/{CAMERA}/count"].to_pylist() == [[n] for n in new_1.lengths]


@given(st.lists(st.integers(1, 90), min_size=1))
def test_a_row_group_has_whole_episodes_and_more_than_a_few_rows(lengths: list[int]) -> None:
    stops, groups = np.cumsum(lengths).tolist(), row_groups(lengths)
    assert set(np.cumsum(groups).tolist()) <= set(stops) and sum(groups) == sum(lengths)
    assert all(group >= GROUP for group in groups[:-1])
    assert all(group < GROUP + max(lengths) for group in groups)
    if min(lengths) >= GROUP:
        assert groups == lengths, "an episode each, as LeRobot has it"


def test_what_nobody_asked_is_an_empty_dataset(unasked: Dataset, tmp_path: Path) -> None:
    summary = select(unasked, tmp_path / "new")
    assert (summary.episodes, summary.frames, summary.queries) == (0, 0, 0)
    new = Dataset.open(tmp_path / "new")
    assert (len(new), list(new.features)) == (0, list(FEATURES))
    assert new.column("queried").shape == (0,)
    assert list(read_episodes(new)) == []


def test_without_queried_intervention_stands_for_it(rollout_1: Dataset, tmp_path: Path) -> None:
    other = copy(rollout_1, tmp_path / "other")
    drop_column("queried")(other)
    select(Dataset.open(other), tmp_path / "new")
    new = Dataset.open(tmp_path / "new")
    assert len(new) == rollout_1.column("intervention").sum()
    assert new.column("queried").all() and new.column("intervention").all()


def test_refuses_what_does_not_tell_who_was_asked(rollout_1: Dataset, tmp_path: Path) -> None:
    other = copy(rollout_1, tmp_path / "other")
    drop_column("queried", "intervention")(other)
    with pytest.raises(ValueError, match=f"^{other}: has neither a column 'queried' nor 'interv"):
        select(Dataset.open(other), tmp_path / "new")
    assert list(tmp_path.iterdir()) == [other]


@pytest.mark.parametrize("frames", [1, 4, 8])
def test_a_sample_has_so_many_frames_each_at_most_once_and_no_gaps(
    rollout_1: Dataset, tmp_path: Path, frames: int
) -> None:
    assert sample(rollout_1, tmp_path / "new", frames, seed=1).frames == frames
    new = Dataset.open(tmp_path / "new")
    episode, frame = (new.column(f"source.{name}").tolist() for name in ("episode", "frame"))
    rows = list(zip(episode, frame, strict=True))
    assert len(set(rows)) == frames and new.column("queried").all()
    assert rows == sorted(rows)
    for start, stop in new.bounds:
        assert np.all(np.diff(new.column("source.frame")[start:stop]) == 1)


def test_a_sample_is_that_of_its_seed(rollout_1: Dataset, tmp_path: Path) -> None:
    kept = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        sample(rollout_1, tmp_path / name, 5, seed)
        new = Dataset.open(tmp_path / name)
        kept.append((new.column("source.episode").tolist(), new.column("source.frame").tolist()))
    assert kept[0] == kept[1] != kept[2]


@pytest.mark.parametrize("frames", [0, 9])
def test_a_sample_is_no_larger_than_what_was_asked(
    rollout_1: Dataset, tmp_path: Path, frames: int
) -> None:
    with pytest.raises(ValueError, match=f"frames is {frames}, expected 1 to the 8 queries of"):
        sample(rollout_1, tmp_path / "new", frames, seed=0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("share", "count"), [(0.5, 2), (0.2, 1)])
def test_whole_episodes_are_set_aside(tmp_path: Path, share: float, count: int) -> None:
    rng = np.random.default_rng(0)
    episodes = [random_episode(rng, 2 + n, episode=n, reference_only=True) for n in range(4)]
    d_0 = write(tmp_path / "D_0", episodes)
    for seed in (0, 1, 0):
        names = [f"{part}{len(list(tmp_path.iterdir()))}" for part in ("rest", "aside")]
        split(d_0, *(tmp_path / name for name in names), share, seed)
        rest, aside = (Dataset.open(tmp_path / name) for name in names)
        assert len(aside.lengths) == count
        numbers = [set(part.column("source.episode").tolist()) for part in (rest, aside)]
        assert sorted([*numbers[0], *numbers[1]]) == [0, 1, 2, 3]
        assert len(rest) + len(aside) == len(d_0)
    assert aside.lineage.own.arguments["part"] == "set aside"
    with pytest.raises(FileExistsError, match="aside: exists already"):
        split(d_0, tmp_path / "rest", aside.path.rename(tmp_path / "aside"), share, 0)
    assert not (tmp_path / "rest").exists()


def test_an_audit_is_no_context(tmp_path: Path) -> None:
    """It has a label, so whoever trains on the selection would learn from it."""
    drive = random_episode(np.random.default_rng(0), 8, asked=[-1, 1, -1, 0, -1, 1, -1, -1])
    select(write(tmp_path / "rollout", [drive]), tmp_path / "new", before=0.3, after=0.3)
    new = Dataset.open(tmp_path / "new")
    assert new.column("source.frame").tolist() == [0, 2, 3, 4, 6]
    assert new.column("queried").tolist() == [False, False, True, False, False]

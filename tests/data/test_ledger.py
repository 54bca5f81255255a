import json
import tempfile
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from pipeline.data.dataset import Dataset
from pipeline.data.ledger import count
from pipeline.data.merging import merge
from pipeline.data.selecting import sample, select
from tests.episodes import random_episode, write

NOTHING = {
    "frames_driven": 0,
    "queries": 0,
    "frames_selected": 0,
    "frames_trained": 7,
    "takeover": 0.0,
}


def test_iteration_zero_is_what_the_reference_drove(d_0: Dataset) -> None:
    assert count(d_0, d_0) == dict(
        frames_driven=7, queries=7, frames_selected=7, frames_trained=7, takeover=1.0
    )


def test_dagger_pays_for_labels_that_it_throws_away(d_0: Dataset, tmp_path: Path) -> None:
    # all ten rows labelled while the primary drives, of which five are kept
    raw = random_episode(np.random.default_rng(0), 10, iteration=1)
    raw.columns["intervention"][:], raw.columns["queried"][:] = False, True
    driven = write(tmp_path / "raw", [raw])
    sample(driven, tmp_path / "selected", 5, seed=0)
    merge([d_0, Dataset.open(tmp_path / "selected")], tmp_path / "D_1")
    assert count(driven, Dataset.open(tmp_path / "D_1")) == dict(
        frames_driven=10, queries=10, frames_selected=5, frames_trained=12, takeover=0.0
    )


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
        ledger = count(driven, Dataset.open(root / "D_1"))
        queried = driven.column("queried")

    assert kept.frames == queried.sum() == unsafe
    assert merged.frames == 7 + kept.frames
    assert ledger == dict(
        frames_driven=sum(lengths),
        queries=unsafe,
        frames_selected=unsafe,
        frames_trained=7 + unsafe,
        takeover=unsafe / sum(lengths),
    )
    assert kept.queries == ledger["queries"]


def test_a_ledger_is_plain_numbers(d_0: Dataset) -> None:
    numbers = count(d_0, d_0)
    assert json.loads(json.dumps(numbers)) == numbers
    assert [type(number) for number in numbers.values()] == [int, int, int, int, float]


def test_a_rollout_in_which_nothing_was_asked_cost_nothing(d_0: Dataset, tmp_path: Path) -> None:
    drive = random_episode(np.random.default_rng(0), 4, iteration=1)
    for name in ("intervention", "queried"):
        drive.columns[name][:] = False
    driven = write(tmp_path / "raw", [drive])
    select(driven, tmp_path / "selected")
    nothing = Dataset.open(tmp_path / "selected")
    merge([d_0, nothing], tmp_path / "D_1")
    assert count(driven, Dataset.open(tmp_path / "D_1")) == NOTHING | {"frames_driven": 4}
    assert count(nothing, d_0) == NOTHING

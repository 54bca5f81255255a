"""What dvc.lock says of where things come from, here of the project's own."""

import shlex
from pathlib import Path

from pipeline.cards.lineage import Origin, read_origins, whole

ROOT = Path(__file__).parents[2]


def test_every_dataset_and_policy_of_the_projects_lock_has_an_origin() -> None:
    origins = read_origins(ROOT / "dvc.lock")
    rollout = origins[whole(ROOT / "datasets/rollout_safedagger_2")]
    assert rollout.stage == "rollout"
    assert rollout.option("--iteration") == "2"
    assert [path.name for path in rollout.parents] == [
        "primary_safedagger_1",
        "safety_safedagger_1",
    ]
    assert origins[whole(ROOT / "cards/metrics/seed_0/driving_0.json")].stage == "evaluate"


def test_a_shown_command_is_the_command() -> None:
    for origin in read_origins(ROOT / "dvc.lock").values():
        block = origin.shown().split("```sh\n")[1].removesuffix("\n```")
        assert shlex.split(block.replace("\\\n", "")) == shlex.split(origin.command)
        for line in block.splitlines():
            assert len(line) <= 102 or " --" not in line.strip()  # an option stays whole


def test_an_option_that_was_not_given_is_none() -> None:
    assert Origin("safedagger select a b --cut", ()).option("--cut") is None
    assert Origin("safedagger select a b", ()).option("--cut") is None
    assert Origin("safedagger", ()).stage == ""

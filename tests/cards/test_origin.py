"""What safedagger.json says, as a card shows it."""

import shlex

from pipeline.cards.origin import shown
from pipeline.data.lineage import Made

LONG = Made(
    "D_safe",
    {"purpose": "D_safe", "tracks": "alder, birch", "include_brake": False, "mirror": True}
    | {f"number_{n}": 0.5 for n in range(12)},
    (),
)


def words(made: Made) -> list[str]:
    block = shown(made).split("```sh\n")[1].removesuffix("\n```")
    assert all(len(line) <= 102 for line in block.splitlines())
    return shlex.split(block.replace("\\\n", ""))


def test_it_is_the_command_as_one_types_it() -> None:
    typed = words(LONG)
    assert typed[:2] == ["safedagger", "collect"]
    assert typed[typed.index("--tracks") + 1] == "alder, birch"
    assert "--no-include-brake" in typed and "--mirror" in typed
    assert typed[typed.index("--number-11") + 1] == "0.5"


def test_each_purpose_has_its_command() -> None:
    assert words(Made("primary", {"seed": 1}, ())) == ["safedagger", "train-primary", "--seed", "1"]
    assert words(Made("merge", {}, ())) == ["safedagger", "merge"]
    rollout = Made("rollout", {"cut": 0.5, "labels": {"tau": 0.1}}, ())
    assert words(rollout) == ["safedagger", "rollout", "--cut", "0.5"]

"""What must stay as it is while the house is rebuilt: D_0 and D_safe at the default scale.

Their observations, actions and affordances were byte for byte the same on three processors.
"""

import json
from pathlib import Path

import pytest

from tests.command import run
from tests.content import column_hashes

HELD = Path(__file__).parents[1] / "held"
SHARED = (
    "--tracks alder,birch,cedar,hazel,larch,maple,rowan --traffic 20 --action-repeat 3 --seconds 4 "
    "--iteration 0 --seed 0 --workers 2"
)
SCALE = {
    "D_0": "--episodes 70 --offset-spread 0.3 --angle-spread 0.03",
    "D_safe": "--episodes 140 --offset-spread 0.9 --angle-spread 0.1",
}


@pytest.mark.parametrize("name", SCALE)
def test_what_the_reference_collects_is_what_it_was(name: str, tmp_path: Path) -> None:
    assert run(f"collect {tmp_path}/{name} --purpose {name} {SHARED} {SCALE[name]}") == 0
    held = json.loads((HELD / f"{name}.json").read_text())
    found = column_hashes(tmp_path / name)
    assert {column: found.get(column) for column in held} == held

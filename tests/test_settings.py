"""What a command can be told."""

import pytest

from pipeline.settings import listed


@pytest.mark.parametrize(
    ("told", "names"),
    [("yew", ["yew"]), ("yew, alder,yew", ["yew", "alder"]), ("", [""]), ("yew,", ["yew", ""])],
)
def test_names_are_listed_once_and_none_is_left_out(told: str, names: list[str]) -> None:
    """An empty one too, so that whoever knows the names can say that it is none of them."""
    assert listed(told) == names

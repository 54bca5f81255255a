from pathlib import Path

import pytest

from pipeline.output import new_directory


def test_a_directory_appears_when_the_block_ends(tmp_path: Path) -> None:
    with new_directory(tmp_path / "out") as folder:
        folder.mkdir()
        (folder / "file").write_text("content")
        assert not (tmp_path / "out").exists()
    assert (tmp_path / "out" / "file").read_text() == "content"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_of_a_block_that_fails(tmp_path: Path, error: type[BaseException]) -> None:
    with pytest.raises(error), new_directory(tmp_path / "out") as folder:
        folder.mkdir()
        raise error
    assert list(tmp_path.iterdir()) == []


def test_what_is_there_is_refused_before_the_block(tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "nowhere")
    with pytest.raises(FileExistsError, match="exists already"), new_directory(tmp_path / "out"):
        pytest.fail("the block was entered")

import fcntl
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pipeline.output import SCRATCH, check_place, new_directory, write_file


def test_a_directory_appears_when_the_block_ends(tmp_path: Path) -> None:
    with new_directory(tmp_path / "out") as folder:
        folder.mkdir()
        (folder / "file").write_text("content")
        assert not (tmp_path / "out").exists()
    assert (tmp_path / "out" / "file").read_text() == "content"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_of_a_block_that_fails(tmp_path: Path, error: type[BaseException]) -> None:
    (tmp_path / "there").mkdir()
    with pytest.raises(error), new_directory(tmp_path / "there" / "new" / "too" / "out") as folder:
        folder.mkdir()
        raise error
    assert list(tmp_path.rglob("*")) == [tmp_path / "there"]


def test_what_is_there_is_refused_before_the_block(tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "nowhere")
    with pytest.raises(FileExistsError, match="exists already"), new_directory(tmp_path / "out"):
        pytest.fail("the block was entered")


def test_a_file_is_replaced_whole_and_may_have_any_name(tmp_path: Path) -> None:
    file = tmp_path / "new" / ("n" * os.pathconf(tmp_path, "PC_NAME_MAX"))
    check_place(file)
    for content in (b"one", b"two"):
        write_file(file, content)
        assert file.read_bytes() == content
    assert [path.name for path in file.parent.iterdir()] == [file.name]


@pytest.mark.parametrize(
    ("place", "problem"),
    [
        ("n" * 300, "the name is too long"),
        ("new/" + "n" * 300 + "/file", "the name is too long"),
        ("file/in/it", "nothing can be written there (Not a directory)"),
        ("/proc/x.csv", "/proc/x.csv: nothing can be written there ("),
        ("there", "exists already"),
    ],
)
def test_a_place_is_tried_before_any_work(tmp_path: Path, place: str, problem: str) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "there").mkdir()
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises((ValueError, FileExistsError)) as caught:
        check_place(tmp_path / "free", tmp_path / "new" / "free", tmp_path / place)
    assert problem in str(caught.value) and "\n" not in str(caught.value)
    assert sorted(tmp_path.rglob("*")) == before


KILLED = """
import os, signal, sys
from pathlib import Path
from pipeline.output import new_directory
with new_directory(Path(sys.argv[1])) as folder:
    folder.mkdir()
    (folder / "half").write_text("written")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_place_is_given_once(tmp_path: Path) -> None:
    check_place(tmp_path / "a", None, None, tmp_path / "b")
    with pytest.raises(ValueError, match=r"a: given twice, expected a path for each output$"):
        check_place(tmp_path / "a", tmp_path / "b", tmp_path / "a")


def test_what_a_killed_command_left_is_swept_by_the_next(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "out")], check=False)
    (stale,) = tmp_path.iterdir()
    assert stale.name.startswith(SCRATCH)
    write_file(tmp_path / "young", b"")
    assert stale.exists()  # it might be another command's that has only just begun
    _age(stale)
    write_file(tmp_path / "old", b"")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["old", "young"]


def test_a_command_that_is_still_at_work_is_left_alone(tmp_path: Path) -> None:
    with new_directory(tmp_path / "out") as folder:
        folder.mkdir()
        _age(folder.parent)
        write_file(tmp_path / "other", b"")
        assert folder.exists()
        with open(folder.parent / ".lock") as lock, pytest.raises(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    assert (tmp_path / "out").is_dir()


def _age(folder: Path) -> None:
    hour_ago = time.time() - 3600
    os.utime(folder, (hour_ago, hour_ago))


def test_git_and_dvc_do_not_see_scratch_folders() -> None:
    root = Path(__file__).parent.parent
    for ignored in (".gitignore", ".dvcignore"):
        assert f"{SCRATCH}*" in (root / ignored).read_text().splitlines()


def test_git_does_not_see_what_stages_make() -> None:
    """Whatever DVC writes there or takes away where a stage fails."""
    root = Path(__file__).parent.parent
    made = ["datasets/D_0/data/x", "datasets/rollout_1/meta/x", "models/primary_0/x"]
    found = subprocess.run(
        ["git", "check-ignore", *made], cwd=root, capture_output=True, text=True, check=True
    )
    assert found.stdout.split() == made

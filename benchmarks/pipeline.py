"""Where the processor's time of a whole `dvc repro` goes, at a tenth of the default scale: what the
main thread of each stage's processes is at, looked at a hundred times a second. Start-up does not
grow with the scale, the rest does. The floor is the sum, and so the ratio a share; in the last
row the floor is what passed meanwhile, and the ratio how many cores were busy.
"""

import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from benchmarks.timing import Row, seconds

ROOT = Path(__file__).parents[1]
TENTH: dict[str, Any] = {
    "d-0": {"episodes": 7},
    "d-safe": {"episodes": 14},
    "primary-0": {"samples": 2000},
    "train-safety": {"samples": 4800},
    "rollout": {"frames": 4000},
    "evaluate": {"laps": 0.3, "seconds": 20},
    "lap": {"laps": 0.1, "seconds": 12},
    "crowd": {"laps": 0.1, "seconds": 12},
    "film": {"laps": 0.1, "seconds": 6},
}
RUN = {"queries": [300, 300, 100], "samples": [4000]}

WATCH = """
import os, sys, threading, time
KINDS = {  # the innermost file on the stack that tells
    "network": ("/driving/network", "/driving/lesson", "/driving/mirroring", "/policies/",
                "/learning/", "/torch/"),
    "simulation": ("/driving/", "/rollout/"),
    "reading and writing": ("/data/", "/pyarrow/", "/datasets/", "/lerobot/", "/output.py"),
    "between processes": ("/joblib/", "/multiprocessing/"),
    "pictures, cards, report": ("/inspection/", "/report/", "/cards/", "/evaluation/", "/matplotlib/"),
}
def kind(frame):
    files = []
    while frame:
        files.append(frame.f_code.co_filename)
        frame = frame.f_back
    if any(name.startswith("<frozen importlib") for name in files):
        return "start-up"
    for name in files:
        for what, parts in KINDS.items():
            if any(part in name for part in parts):
                return what
    return "other"
def watch(main, out, last):
    while True:
        time.sleep(0.01)
        now = time.process_time()
        print(kind(sys._current_frames().get(main)), now - last, sep=",", file=out, flush=True)
        last = now
if "DVC_STAGE" in os.environ:
    out = open(os.path.join(os.environ["WATCHED"], str(os.getpid())), "a")
    given = threading.main_thread().ident, out, time.process_time()
    threading.Thread(target=watch, args=given, daemon=True).start()
"""


def rows() -> Iterator[Row]:
    """Seconds of the processor by what it was at, the most first."""
    with tempfile.TemporaryDirectory() as made:
        root = Path(made)
        _house(root)
        taken = seconds(lambda: _dvc(root, "repro"))
        spent: Counter[str] = Counter()
        for file in (root / "watched").iterdir():
            for line in file.read_text().splitlines():
                what, _, passed = line.rpartition(",")
                spent[what] += float(passed)  # type: ignore[assignment]
    total = sum(spent.values())
    for what, time in spent.most_common():
        yield Row(what, time, total, "s", time / total)
    yield Row("all of it", total, taken, "s", total / taken)


def _house(root: Path) -> None:
    """The project's own pipeline with other parameters, as `scales/run` makes one."""
    params = yaml.safe_load((ROOT / "params.yaml").read_text())
    for group, values in TENTH.items():
        params[group] |= values
    params["runs"]["safedagger"] |= RUN
    for name in (".dvcignore", "pipeline", "stages", "dvc.yaml"):
        (root / name).symlink_to(ROOT / name)
    for name in ("watched", "cards/curves", "cards/frames", ".dvc"):
        (root / name).mkdir(parents=True)
    (root / "sitecustomize.py").write_text(WATCH)
    (root / "params.yaml").write_text(yaml.safe_dump(params, sort_keys=False))
    config = (ROOT / ".dvc/config").read_text()
    (root / ".dvc/config").write_text(config.replace("[core]", "[core]\n    no_scm = true"))
    _python(root, "-m", "stages", "plan")


def _dvc(root: Path, *words: str) -> None:
    _python(root, "-m", "dvc", *words)


def _python(root: Path, *words: str) -> None:
    bin_, before = Path(sys.executable).parent, os.environ
    changed = {
        "PATH": f"{bin_}{os.pathsep}{before['PATH']}",
        "PYTHONPATH": os.pathsep.join(filter(None, (str(root), before.get("PYTHONPATH")))),
        "WATCHED": str(root / "watched"),
    }
    done = subprocess.run(
        [sys.executable, *words], cwd=root, env=before | changed, capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(done.stdout + done.stderr)


if __name__ == "__main__":
    from benchmarks.timing import table

    print(table(rows()))

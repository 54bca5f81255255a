"""`make bench`: all rows in one table, with what they were measured on."""

import os
import platform
import re
from datetime import date
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from benchmarks.timing import table
from stages.__main__ import ENVIRONMENT

HERE = Path(__file__).parent
PARTS = sorted({file.stem for file in HERE.glob("[!_]*.py")} - {"timing"})
PAGE = HERE.parent / "docs" / "benchmarks.md"

HEAD = """\
# How fast each part is

Written by `make bench` on {day}, on {machine}. Ours and its floor are
measured in turns, in one run: on another machine, or beside other work, the ratios are what holds. A
ratio is the median of the turns' own, which need not be that of the two medians beside it.
A row that begins with *of* says what another is made of: its floor is the whole, its ratio the share.
"""


def machine() -> str:
    """Processor, cores, and the libraries that compute."""
    info = Path("/proc/cpuinfo")
    named = re.search(r"^model name\s*: (.+)$", info.read_text() if info.exists() else "", re.M)
    libraries = ", ".join(f"{name} {version(name)}" for name in ("torch", "numpy", "pyarrow"))
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{cores} cores of {named[1] if named else platform.machine()} with {libraries}"


def main() -> None:
    """Measure part by part and write the page."""
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    page = [HEAD.format(day=date.today(), machine=machine())]
    for part in PARTS:
        print(f"{part} ...", flush=True)
        module = import_module(f"benchmarks.{part}")
        measured = table(module.rows())
        print(measured, flush=True)  # nothing that took so long is lost where a later part fails
        page += [f"## {part.capitalize()}\n", f"{module.__doc__}\n", measured + "\n"]
    PAGE.write_text("\n".join(page))
    print(PAGE)


if __name__ == "__main__":
    main()

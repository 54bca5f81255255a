"""What the threshold decides: the supervised primary with safety policies of several tau."""

import re
from collections import defaultdict
from pathlib import Path

from pipeline.evaluation.drives import read_drives
from pipeline.evaluation.experiment import Experiment, Step, read_step
from pipeline.runs import FIRST

RUN = FIRST
"""Stands for all runs that begin with this primary."""
_DRIVES = re.compile(r"seed_(?P<seed>\d+)/drives_(?P<name>0|tau_\d+)\.csv")


def read_thresholds(metrics: Path) -> dict[float, Experiment]:
    """By tau, ascending: iteration 0 of RUN with a safety policy of that tau, on all seeds.

    Reads seed_<n>/drives_tau_<digits>.csv and its companions, and iteration 0's own beside them.
    Empty where there are none.

    Raises:
        ValueError: a file does not hold what it should; two of a seed have the same tau.
        FileNotFoundError: a companion of a file of drives is missing.
    """
    files = (path.relative_to(metrics).as_posix() for path in metrics.glob("seed_*/drives_*.csv"))
    found = [named for file in sorted(files) if (named := _DRIVES.fullmatch(file))]
    varied = {named["seed"] for named in found if named["name"] != "0"}
    watched = {
        seed: set(read_drives(metrics / f"seed_{seed}" / f"drives_{FIRST}.csv").primary)
        for seed in sorted(varied)
    }
    steps: dict[float, dict[tuple[int, str, int], Step]] = defaultdict(dict)
    for named in found:
        if named["seed"] in varied:
            folder, name = metrics / f"seed_{named['seed']}", named["name"]
            step = read_step(folder, int(named["seed"]), RUN, 0, name)
            if set(step.drives.primary) != watched[named["seed"]]:
                continue  # it watched another primary, of an earlier run
            if (step.seed, RUN, 0) in steps[step.tau]:
                problem = f"tau is {step.tau:g} again, expected another"
                raise ValueError(f"{metrics / named[0]}: {problem}")
            steps[step.tau][step.seed, RUN, 0] = step
    return {tau: Experiment(steps[tau], {}) for tau in sorted(steps)}

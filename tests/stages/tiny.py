"""The project's own pipeline with tiny parameters, to be reproduced from nothing."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

from tests.command import run

HOUSE = Path(__file__).parents[2]
TINY: dict[str, Any] = yaml.safe_load("""
each: &each
  {samples: [128], protocol: anywhere, tau: [0.0025], driven_by: "naive,safe,optimal", words: One.,
  colour: black, marker: o}
runs:
  safedagger: {<<: *each, strategy: safedagger, name: SafeDAgger, queries: [12, 12],
    from_scratch: [2]}
  dagger: {<<: *each, strategy: dagger, name: DAgger, frames: [30], sample: [12]}
  supervised: {<<: *each, strategy: supervised, name: supervised, episodes: [2], protocol: briefly}
  ahead: {<<: *each, strategy: safedagger, name: Ahead, variant_of: safedagger, queries: [12],
    horizon: 0.5, horizon_mode: max, driven_by: safe}
  audited: {<<: *each, strategy: safedagger, name: Audited, variant_of: safedagger, queries: [12],
    audit: 0.5, set_aside: 0.75, driven_by: safe}
  partly: {<<: *each, strategy: safedagger, name: Partly, variant_of: safedagger, queries: [12],
    d_safe: 0.75, driven_by: ""}
  more: {<<: *each, strategy: training, name: more training, driven_by: ""}
tracks: {training: "alder,birch", test: yew}
contact-sheet: {frames: 2}
film: {traffic: 2, seconds: 2}
drive: {traffic: 3}
d-0: {episodes: 4, seconds: 1}
d-safe: {episodes: 4, seconds: 1}
primary-0: {samples: 192}
train-primary: {channels: 4}
train-safety: {samples: 256, hidden: 8, cut: 1.0}
rollout: {frames: 60}
protocols:
  anywhere: {seconds: 2, offset-spread: 0.3, angle-spread: 0.03}
  briefly: {seconds: 1, offset-spread: 0.3, angle-spread: 0.03}
reliability: {ends: "random:1-2", between: "random:1", crowded: "random:2"}
lap: {traffic: 2, laps: 0.05, seconds: 2}
crowd: {traffic: 4, laps: 0.05, seconds: 2}
evaluate: {traffic: 2, laps: 0.05, seconds: 2, starts: 1}
""")
del TINY["each"]
RUNS = TINY["runs"]


def linked(root: Path, tiny: dict[str, Any]) -> None:
    """The project's own code and pipeline, with other parameters and their loops."""
    for name in (".dvcignore", "pipeline", "stages", "dvc.yaml"):
        (root / name).symlink_to(HOUSE / name)
    plan(root, tiny)


def reproduced(root: Path, tiny: dict[str, Any]) -> Path:
    """From nothing to the report."""
    linked(root, tiny)
    for name in ("curves", "frames"):
        (root / "cards" / name).mkdir(parents=True)
    dvc(root, "init --no-scm")
    settings = (HOUSE / ".dvc" / "config").read_text()
    (root / ".dvc" / "config").write_text(settings.replace("[core]", "[core]\n    no_scm = true"))
    dvc(root, "repro")
    return root


def plan(root: Path, tiny: dict[str, Any]) -> None:
    """Write the parameters and the loops."""
    params = yaml.safe_load((HOUSE / "params.yaml").read_text())
    for group, values in tiny.items():
        params[group] = params[group] | values if group != "runs" else values
    (root / "params.yaml").write_text(yaml.safe_dump(params, sort_keys=False))
    assert run(f"plan --params {root}/params.yaml --loops {root}/loops.yaml") == 0


def dvc(root: Path, command: str) -> str:
    """What a DVC command prints; the stages it runs find this Python's commands first."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [Path(sys.executable).parent / "dvc", *command.split()],
        cwd=root,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout

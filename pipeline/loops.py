"""The loops of dvc.yaml, unrolled from the runs of a comparison: a step is "0" or <run>_<iteration>."""

import json
from collections.abc import Iterator
from typing import Any

from pipeline.runs import FIRST, Comparison, Run, safe_data, start

NAIVE_AND_SAFE, SAFE = "naive,safe", "safe"


def loops(comparison: Comparison) -> dict[str, Any]:
    """The loops of dvc.yaml: of each, by step, what is told to its stages."""
    steps = list(_steps(comparison))
    safeties = dict(_safeties(comparison))
    parts = {
        safe_data(name, run): {"share": run.d_safe}
        for name, run in comparison.runs.items()
        if run.has_own_d_safe
    }
    audits = {step: i for step, _, run, i in steps if run.audit and step in safeties}
    return {
        "set-aside": {
            start(name, run): {"share": run.set_aside}
            for name, run in comparison.runs.items()
            if run.set_aside
        },
        "parts-of-D_safe": parts,
        "rollouts": {
            step: {
                "iteration": i,
                "primary": before(name, run, i),
                "safety": _safety(comparison, name, i - 1),
                "asks": run.asks(i),
                "protocol": comparison.protocols[run.protocol],
            }
            for step, name, run, i in steps
            if run.strategy == "safedagger"
        },
        "audits": {
            step: {"selected": f"{'new' if i > 1 else 'D'}_audits_{step}"}
            for step, i in audits.items()
        },
        "dagger": {
            step: {
                "iteration": i,
                "previous": before(name, run, i),
                "beta": run.beta,
                "ask": run.ask,
                "frames": run.frames[i - 1],
                "sample": run.sample[i - 1],
                "protocol": comparison.protocols[run.protocol],
            }
            for step, name, run, i in steps
            if run.strategy == "dagger"
        },
        "supervised": {
            step: {
                "iteration": i,
                "episodes": run.episodes[i - 1],
                "protocol": comparison.protocols[run.protocol],
            }
            for step, _, run, i in steps
            if run.strategy == "supervised"
        },
        "merges": {
            **{
                step: {"previous": before(name, run, i)}
                for step, name, run, i in steps
                if run.collects
            },
            **{
                f"audits_{step}": {"previous": f"audits_{before(name, run, i)}"}
                for step, name, run, i in steps
                if step in audits and i > 1
            },
        },
        "steps": {
            step: {
                "previous": before(name, run, i),
                "data": _data(run, name, i),
                "samples": run.shown(i),
            }
            for step, name, run, i in steps
        },
        "from-scratch": {
            scratch(i): {"data": step, "samples": run.shown(i)}
            for step, _, run, i in steps
            if i in run.from_scratch
        },
        "safeties": {step: of for step, of in safeties.items() if step not in audits},
        "safeties-audited": {step: of for step, of in safeties.items() if step in audits},
        "evaluated": {
            step: {"primary": of["primary"], "strategies": of["strategies"]}
            for step, of in safeties.items()
            if of["strategies"]
        },
        "relied-on": dict(_relied_on(comparison)),
        "crowded": dict(_crowded(comparison)),
        "pictured": [f"{name}_1" for name, run in comparison.runs.items() if run.is_watched][:1],
        "ledgers": {
            FIRST: {"driven": "D_0"},
            **{of: {"driven": f"D_{of}"} for of in ("safe", *parts)},
            **{
                step: {"driven": f"{'new' if run.strategy == 'supervised' else 'rollout'}_{step}"}
                for step, _, run, _ in steps
                if run.collects
            },
        },
    }


def render(comparison: Comparison) -> str:
    """The loops as YAML, a step a line."""
    head = "# Written by `safedagger plan` from the runs in params.yaml: edit those.\n"
    return head + "".join(
        f"{loop}: {json.dumps(steps)}\n"
        if isinstance(steps, list) or not steps
        else f"{loop}:\n"
        + "".join(f"  {json.dumps(k)}: {json.dumps(v)}\n" for k, v in steps.items())
        for loop, steps in loops(comparison).items()
    )


def before(name: str, run: Run, iteration: int) -> str:
    """The step that an iteration of a run follows."""
    return f"{name}_{iteration - 1}" if iteration > 1 else start(name, run)


def scratch(iteration: int) -> str:
    """The step of a primary without a warm start."""
    return f"scratch_{iteration}"


def _steps(comparison: Comparison) -> Iterator[tuple[str, str, Run, int]]:
    """Every step of every loop: its name, its run's and that run, and its iteration."""
    for name, run in comparison.runs.items():
        for i in run.iterations:
            yield f"{name}_{i}", name, run, i


def _data(run: Run, name: str, iteration: int) -> str:
    """The step of the data that is trained on."""
    return f"{name}_{iteration}" if run.collects and iteration > 0 else start(name, run)


def _safety(comparison: Comparison, name: str, iteration: int) -> str:
    """The safety policy after an iteration; all runs with the same labels and all of D_safe share the
    first.
    """
    first, run = next(iter(comparison.runs.values())), comparison.runs[name]
    alike = safe_data(name, run) == "safe" and run.labels(0) == first.labels(0)
    return FIRST if iteration == 0 and alike else f"{name}_{iteration}"


def _safeties(comparison: Comparison) -> Iterator[tuple[str, dict[str, Any]]]:
    first = next(iter(comparison.runs.values()))
    for name, run in comparison.runs.items():
        drives_on = run.iterations if run.is_watched else ()
        for i in (0, *run.iterations):
            safety, strategies = _safety(comparison, name, i), run.driven_by
            if safety == FIRST:
                if run is not first:
                    continue  # the first run's, already
                strategies = _of_all_that_share_it(comparison)
            elif not strategies and i + 1 not in drives_on:
                continue  # nobody asks it; the first one drives in the film
            about: dict[str, Any] = {
                "primary": before(name, run, i + 1),
                "safe": safe_data(name, run),
            }
            about |= {"data": _data(run, name, i), "labels": run.labels(i)}
            yield safety, about | {"strategies": strategies}
        for i in run.from_scratch:
            about = {"primary": scratch(i), "safe": safe_data(name, run)}
            about |= {"data": _data(run, name, i), "labels": run.labels(i)}
            yield scratch(i), about | {"strategies": NAIVE_AND_SAFE}
    for tau in comparison.thresholds:
        about = {"primary": FIRST, "safe": "safe", "data": FIRST}
        about |= {"labels": first.labels(0) | {"tau": tau}}
        yield f"tau_{f'{tau:.12f}'[2:].rstrip('0')}", about | {"strategies": SAFE}


def _of_all_that_share_it(comparison: Comparison) -> str:
    """The strategies by which the supervised stage is evaluated, each once."""
    sharing = [
        run for name, run in comparison.runs.items() if _safety(comparison, name, 0) == FIRST
    ]
    return ",".join(dict.fromkeys(each for run in sharing for each in run.strategies))


def _relied_on(comparison: Comparison) -> Iterator[tuple[str, dict[str, str]]]:
    """Of each primary, the scenarios in which it is counted on."""
    there = comparison.reliability
    if there is None:
        return
    ends = set(_ends(comparison))
    for step in (*_beginnings(comparison), *(step for step, *_ in _steps(comparison))):
        scenarios = there.ends if step in ends else there.between
        if scenarios:
            yield step, {"scenarios": scenarios}


def _crowded(comparison: Comparison) -> Iterator[tuple[str, dict[str, str]]]:
    """Of the first and the last primaries, the scenarios in which they are counted on in a crowd."""
    there = comparison.reliability
    if there is not None and there.crowded:
        for step in _ends(comparison):
            yield step, {"scenarios": there.crowded}


def _ends(comparison: Comparison) -> Iterator[str]:
    """The steps of the supervised stages and of each run's last iteration."""
    yield from _beginnings(comparison)
    yield from (step for step, _, run, i in _steps(comparison) if i == run.iterations[-1])


def _beginnings(comparison: Comparison) -> list[str]:
    """The steps of the supervised stages, each once."""
    return list(dict.fromkeys(start(name, run) for name, run in comparison.runs.items()))

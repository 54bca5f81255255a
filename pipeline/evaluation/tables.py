"""The report's tables, each with the words that explain it."""

from collections.abc import Mapping

from pipeline.data.ledger import Ledger, cumulative
from pipeline.evaluation.results import STRATEGIES, Iteration, Results, SafetyQuality
from pipeline.evaluation.summary import CONDITIONS, LAPS, Performance, measure
from pipeline.evaluation.wording import NOTHING, amount, count, laps, ratio, share, table
from pipeline.policies.strategies import Strategy

DRIVING = {
    "laps": ("Laps", laps),
    "damage_per_lap": ("Damage per lap", amount),
    "steering_mse": ("Steering MSE", amount),
}
BASIS = {
    "off_road": ("Left the road", share),
    "drives": ("Drives", count),
    "measuring_queries": ("Frames of the MSE", count),
}
SAFETY = {
    "auroc": ("AUROC", ratio),
    "recall": ("Recall of unsafe", share),
    "precision": ("Precision of unsafe", share),
    "share_unsafe": ("Truly unsafe", share),
    "share_predicted_unsafe": ("Called unsafe", share),
}
UNKNOWN = SafetyQuality(None, None, None, None, None)


def driving(results: Results) -> str:
    """The metrics of Sec. 4.4, a row per iteration, and what they rest on."""
    metrics = [
        [str(step.number), *_driving_cells(step.driving, DRIVING), *_takeover(step.driving)]
        for step in results.iterations
    ]
    basis = [
        [str(step.number), *_driving_cells(step.driving, BASIS)] for step in results.iterations
    ]
    return "\n\n".join(
        [
            f"Each cell: without traffic / with traffic ({_cars(results.last)}). Laps are the mean "
            f"over {', '.join(results.last.tracks)}, {LAPS:g} at most, halted on leaving the road. "
            "Damage is in m²/s² per lap driven. The steering MSE is per frame that the primary "
            "drove, full lock = 1. Takeover is the share of the frames that the reference drove, "
            "under the safe strategy.",
            table(["Iteration", *_headers(DRIVING), "Takeover, safe"], metrics),
            "What this rests on:",
            table(["Iteration", *_headers(BASIS)], basis),
        ]
    )


def tracks(iteration: Iteration) -> str:
    """The same metrics, a row per track, of one iteration."""
    rows = []
    for track in iteration.tracks:
        performances = {
            strategy: {
                where: measure(iteration.drives_of(strategy, where, track)) for where in CONDITIONS
            }
            for strategy in STRATEGIES
        }
        rows.append([track, *_driving_cells(performances, DRIVING), *_takeover(performances)])
    header = ["Track", *_headers(DRIVING), "Takeover, safe"]
    return f"Each cell: without traffic / with traffic.\n\n{table(header, rows)}"


def ledger(results: Results) -> str:
    """Frames driven, queries and frames trained on, of each iteration and so far."""
    rows = [
        ["D_0", *_counts(results.first.ledger), *[NOTHING] * 3],
        ["D_safe", *_counts(results.d_safe)[:3], *[NOTHING] * 5],
    ]
    totals = cumulative([step.ledger for step in results.loop])
    for step, total in zip(results.loop, totals, strict=True):
        so_far = [count(total.frames_driven), count(total.queries), share(total.takeover)]
        rows.append([str(step.number), *_counts(step.ledger), *so_far])
    header = [
        "Iteration",
        "Frames driven",
        "Queries",
        "Driven by the reference",
        "Frames selected",
        "Frames trained on",
        "Driven so far",
        "Queries so far",
        "By the reference so far",
    ]
    return (
        "A query is a frame in which the reference was asked for an action to drive or to train "
        "with. Trained on is D_i: D_0 and all that was selected so far. D_0 and D_safe are driven "
        "by the reference alone and stand apart from the loop, as in the paper; D_safe never "
        f"trains a primary.\n\n{table(header, rows)}"
    )


def safety(results: Results) -> str:
    """How well each safety policy finds the unsafe frames."""
    rows = [
        [str(step.number), f"{step.tau:g}", *_safety_cells(step)] for step in results.iterations
    ]
    header = ["Iteration", "tau", *(words for words, _ in SAFETY.values())]
    return (
        "Each cell: held-out frames of D_safe, which the reference drove / frames of the next "
        "rollout, which this safety policy decided about; after the last iteration there was none. "
        "Truly unsafe is a frame with a deviation above tau.\n\n" + table(header, rows)
    )


def _headers(metrics: Mapping[str, tuple]) -> list[str]:
    return [f"{words}, {strategy}" for words, _ in metrics.values() for strategy in STRATEGIES]


def _driving_cells(
    performances: Mapping[Strategy, Mapping[str, Performance]], metrics: Mapping[str, tuple]
) -> list[str]:
    """A cell for each metric and strategy: without / with traffic."""
    return [
        " / ".join(form(getattr(performances[strategy][where], name)) for where in CONDITIONS)
        for name, (_, form) in metrics.items()
        for strategy in STRATEGIES
    ]


def _takeover(performances: Mapping[Strategy, Mapping[str, Performance]]) -> list[str]:
    """One cell: under the naive strategy nobody takes over."""
    safe = performances[Strategy.SAFE]
    return [" / ".join(share(safe[where].takeover) for where in CONDITIONS)]


def _safety_cells(iteration: Iteration) -> list[str]:
    """A cell for each measure: held-out / next rollout."""
    rollout = iteration.next_rollout or UNKNOWN
    return [
        f"{form(getattr(iteration.held_out, name))} / {form(getattr(rollout, name))}"
        for name, (_, form) in SAFETY.items()
    ]


def _counts(entry: Ledger) -> list[str]:
    return [
        count(entry.frames_driven),
        count(entry.queries),
        share(entry.takeover),
        count(entry.frames_selected),
        count(entry.frames_trained),
    ]


def _cars(iteration: Iteration) -> str:
    levels = sorted({drive.traffic for drive in iteration.drives if drive.traffic > 0})
    return f"{' or '.join(map(str, levels))} cars"

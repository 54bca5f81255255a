"""The report: markdown made from all metrics, every verdict, every number and every gap."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from pipeline.claims.findings import MARGIN, PAIRS
from pipeline.claims.verdicts import Verdict, verdicts
from pipeline.driving.features import STANDSTILL
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import table
from pipeline.metric import shown
from pipeline.report import tables
from pipeline.report.basis import basis, certainty, cost
from pipeline.report.gaps import gaps
from pipeline.report.headline import headline, standing
from pipeline.report.limits import limits
from pipeline.report.material import Material
from pipeline.report.runs import runs
from pipeline.report.scratch import warm_or_scratch
from pipeline.report.shortfalls import falls_short


@dataclass(frozen=True)
class Pictures:
    """Where the pictures lie, seen from the report."""

    result: str | None
    """the one at its head; None where there is nothing to draw"""
    figures: Mapping[str, str]
    """over the iterations, by title"""
    by_seed: Mapping[str, Mapping[int, str]]
    """by title and seed"""
    tracks: Mapping[str, str]
    """by title"""


def render_report(material: Material, pictures: Pictures) -> str:
    """The report as markdown."""
    experiment = material.experiment
    judged = verdicts(experiment)
    sections = [
        "# SafeDAgger: the result",
        standing(judged),
        headline(experiment),
        *_result(pictures),
        cost(material),
        basis(material),
        certainty(experiment),
        "**Runs.** Each begins with the same D_0, and with a supervised primary trained on it:",
        runs(experiment),
        "## Claims of the paper",
        *_claims(judged, tables.most_laps(experiment)),
        "## Over the iterations",
        "Bars are 95 % intervals. Over the iterations lines stand a little apart, so that equal ones "
        "stay visible; over queries and frames only their bars do. Panels in which nothing differs are named "
        "below the others.",
        *(f"{title}:\n\n![{title}]({place})" for title, place in pictures.figures.items()),
        "## In numbers",
        *_numbers(material),
        "## Track by track, after the last iteration",
        "Each cell: without traffic / with traffic, over all starts and seeds.",
        tables.by_track(experiment),
        *_shortfalls(experiment),
        "## Pictures",
        *(_of_seeds(title, places) for title, places in pictures.by_seed.items() if places),
        *(f"![{title}]({place})" for title, place in pictures.tracks.items()),
        "## What is missing",
        "\n".join(f"- {gap}" for gap in gaps(material, pictures.by_seed))
        or "No run, seed or picture is missing.",
    ]
    return "\n\n".join(sections) + "\n"


def _result(pictures: Pictures) -> Iterator[str]:
    if pictures.result:
        yield f"![Naive laps against queries, and takeover]({pictures.result})"


def _claims(judged: Sequence[Verdict], laps: str) -> Iterator[str]:
    """What decides each, in a table, and all numbers below it."""
    yield (
        f"A comparison is of {PAIRS} pairs of drives or more, with equal seeds, tracks and starts. It "
        "is decided where the whole 95 % interval of the difference, in brackets, is on one side of "
        f"0. But laps need not rise where all drives do {laps} in the end, and up to {MARGIN:g} laps "
        "count as none where it is asked who gets further, or as far. Surely and possibly are by the "
        "two ends of the interval."
    )
    rows = [
        [
            f"{number}. {one.claim}",
            one.verdict if one.verdict == "holds" else f"**{one.verdict}**",
            one.observed,
        ]
        for number, one in enumerate(judged, 1)
    ]
    yield table(["Claim", "Verdict", "Observed"], rows, words=3)
    yield "All numbers behind them, by claim:"
    yield "\n".join(f"{number}. {one.evidence}" for number, one in enumerate(judged, 1))


def _numbers(material: Material) -> Iterator[str]:
    """The tables, each group under its heading; those that would be empty are left out."""
    experiment = material.experiment
    yield "### Driving on the test tracks"
    yield (
        "Each cell: without traffic / with traffic, with 95 % intervals. Laps are the mean over "
        f"the drives, {tables.most_laps(experiment)} at most, cut to two digits; their interquartile mean leaves out the best "
        "and the worst quarter, and so shows what is usual. A drive is halted when it leaves the road, "
        f"has stood still for {STANDSTILL:g} s or is out of time. Damage is half the squared closing "
        "speed of each touch, in m²/s² per lap driven. The steering MSE is per frame that the primary "
        "drove, full lock = 1. A frame is one decision: whoever drives is asked once, and the action "
        "is held until the next. Takeover is the share of the frames that the reference drove; a "
        "switch is a change of driver from one frame to the next, either way."
    )
    first, *others = shown(METRICS, "tables")
    yield tables.driving(experiment, first)
    yield (
        "How the drives ended that did not do all laps, in counts. On the road they stopped because "
        "they stood still or were out of time. Rows in which all drives did all laps are left out."
    )
    yield from tables.endings(experiment)
    yield from (tables.driving(experiment, metric) for metric in others)
    yield "### What it cost"
    yield (
        "A query is a frame in which the reference was asked for an action to drive or to train "
        "with. Queries and frames driven are those of the loop. Labels in all are D_0, these queries "
        "and, for the runs whose loop needs a safety policy, D_safe; of the others it exists only to "
        "measure. Trained on is D_i: D_0 and all that was added so far; D_safe never trains a "
        "primary. Means over the seeds."
    )
    yield tables.cost(experiment)
    if any(experiment.specs[run].is_watched for run in experiment.runs):
        yield "### The safety policies"
        yield (
            "Each cell: held-out frames of D_safe, which the reference drove / frames of the next "
            "rollout, which this safety policy decided about; after the last iteration there was "
            "none. Means over the seeds. Truly unsafe is by the labels that it learned: a deviation above "
            "tau, now or one second ahead, or, where that counts, a wrong brake."
        )
        yield tables.safety(experiment)
    if len(material.thresholds.drives):
        yield "### Other thresholds"
        yield (
            "The supervised primary under the safe strategy, with safety policies of several tau. "
            "Truly unsafe is the share of the held-out frames of D_safe that is so by their labels."
        )
        yield tables.thresholds(material.thresholds)
    if len(material.scratch.drives):
        yield "### Warm start or from scratch"
        yield warm_or_scratch(material.scratch)
    if material.errors:
        yield "### Which errors are safe"
        yield (
            "The steering errors of the supervised primary on D_0, which it was trained on, and on "
            "drives like these that nobody trained on: the share of the frames that tau calls safe, "
            "and the tau under which as many of the held-out frames were safe as in the paper."
        )
        yield tables.errors(material.errors)


def _shortfalls(experiment: Experiment) -> Iterator[str]:
    ours = experiment.ours
    if ours in experiment.runs:
        yield f"## Where {experiment.title(ours)} falls short"
        yield falls_short(experiment, ours)
        yield from filter(None, [limits(experiment, ours)])


def _of_seeds(title: str, places: Mapping[int, str]) -> str:
    """The picture of the lowest seed, and links to the others."""
    (first, shown), *others = sorted(places.items())
    links = ", ".join(f"[seed {seed}]({place})" for seed, place in others)
    words = f"{title}, seed {first}"
    also = f" (also {links})" if links else ""
    return f"{words}{also}:\n\n![{words}]({shown})"

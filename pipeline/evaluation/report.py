"""The report of a run: markdown made from its metrics, every figure and every verdict."""

from collections.abc import Mapping

from pipeline.data.ledger import cumulative
from pipeline.evaluation import tables
from pipeline.evaluation.expectations import Check, check_expectations
from pipeline.evaluation.results import STRATEGIES, Iteration, Results
from pipeline.evaluation.shortfalls import Shortfall, shortfalls
from pipeline.evaluation.summary import CONDITIONS, LAPS
from pipeline.evaluation.wording import CONDITION_WORDS, amount, count, laps, share, table
from pipeline.policies.strategies import Strategy


def render_report(results: Results, *, progress: str, pictures: Mapping[str, str]) -> str:
    """The report as markdown.

    Args:
        progress: where the figure over the iterations lies, seen from the report.
        pictures: title to place of each picture at its end.
    """
    checks = check_expectations(results)
    sections = [
        "# SafeDAgger: the result",
        _headline(results, checks),
        f"![Driving, cost and safety policy over the iterations]({progress})",
        _cost(results),
        "## Driving on the test tracks",
        tables.driving(results),
        "## What it cost",
        tables.ledger(results),
        "## The safety policy",
        tables.safety(results),
        f"## Track by track, after iteration {results.last.number}",
        tables.tracks(results.last),
        "## Where the result falls short",
        _shortfalls(results),
        "## Expectations",
        _expectations(checks),
        "## Pictures",
        *(f"![{title}]({place})" for title, place in pictures.items()),
    ]
    return "\n\n".join(sections) + "\n"


def _headline(results: Results, checks: list[Check]) -> str:
    """The result, in sentences that depend on the data."""
    first, last = results.first, results.last
    total = cumulative([iteration.ledger for iteration in results.loop])[-1]
    without, with_traffic = _laps(first, Strategy.NAIVE)
    failed = sum(not check.holds for check in checks)
    verdict = {0: f"All {len(checks)} [expectations](#expectations) hold."}.get(
        failed, f"Of {len(checks)} [expectations](#expectations), {failed} failed."
    )
    return (
        f"Driven naively, the primary completed {without} of {LAPS:g} laps without traffic and "
        f"{with_traffic} with traffic after supervised training; after iteration {last.number} it "
        f"completed {_laps_in_words(last, Strategy.NAIVE)}. In between, the reference was asked "
        f"{count(total.queries)} times, in {share(total.queries / total.frames_driven)} of the "
        "frames driven. "
        f"With the safe strategy it was {_laps_in_words(first, Strategy.SAFE)} at first, the "
        f"reference driving {_takeovers(first)} of the time, and "
        f"{_laps_in_words(last, Strategy.SAFE)} in the end, the reference driving "
        f"{_takeovers(last)}. {verdict}"
    )


def _laps(iteration: Iteration, strategy: Strategy) -> list[str]:
    return [laps(iteration.driving[strategy][where].laps) for where in CONDITIONS]


def _laps_in_words(iteration: Iteration, strategy: Strategy) -> str:
    if all(iteration.driving[strategy][where].laps >= LAPS for where in CONDITIONS):
        return "all of them in both conditions"
    return " and ".join(_laps(iteration, strategy))


def _takeovers(iteration: Iteration) -> str:
    safe = iteration.driving[Strategy.SAFE]
    return " and ".join(share(safe[where].takeover) for where in CONDITIONS)


def _cost(results: Results) -> str:
    total = cumulative([iteration.ledger for iteration in results.loop])[-1]
    in_rollouts = total.frames_driven - total.queries  # each frame's deviation is known
    in_evaluation = sum(
        step.driving[strategy][where].measuring_queries
        for step in results.iterations
        for strategy in STRATEGIES
        for where in CONDITIONS
    )
    return (
        f"**Cost.** {count(total.queries)} queries in the loop, which drove "
        f"{count(total.frames_driven)} frames, after {count(results.first.ledger.queries)} for "
        f"D_0 and {count(results.d_safe.queries)} for D_safe; the last primary was trained on "
        f"{count(total.frames_trained)} frames. Only to measure, never to drive or to train, the "
        f"reference was asked in {count(in_rollouts)} frames of rollouts and "
        f"{count(in_evaluation)} of evaluation."
    )


def _shortfalls(results: Results) -> str:
    last = results.last
    found = shortfalls(last)
    cases = len(STRATEGIES) * len(CONDITIONS) * len(last.tracks)
    if not found:
        return (
            f"Nowhere: after iteration {last.number}, {LAPS:g} laps without damage on every test "
            "track, in both conditions and with both strategies."
        )
    rows = [
        [
            f"{case.strategy}, {CONDITION_WORDS[case.condition]}, {case.track}",
            laps(case.performance.laps),
            amount(case.performance.damage_per_lap),
            f"{case.left} of {case.performance.drives}",
            f"{case.stuck} of {case.performance.drives}",
        ]
        for case in found
    ]
    header = ["Case", "Laps", "Damage per lap", "Left the road", "Stopped short on it"]
    return "\n\n".join(
        [
            f"After iteration {last.number}, {len(found)} of {cases} cases have less than "
            f"{LAPS:g} laps or some damage.",
            table(header, rows),
            _limits(results, found),
        ]
    )


def _limits(results: Results, found: list[Shortfall]) -> str:
    """What the data says about the causes."""
    left, stuck = sum(case.left for case in found), sum(case.stuck for case in found)
    hit = sum(case.hit for case in found)
    sentences = [
        f"In these cases {left} drives ended by leaving the road, {stuck} stood still or ran out "
        f"of time, and {hit} touched another car."
    ]
    collector = results.iterations[-2]
    if collector.next_rollout and collector.next_rollout.recall is not None:
        sentences.append(
            "In the last rollout the safety policy recognised "
            f"{share(collector.next_rollout.recall)} of the truly unsafe frames, against "
            f"{share(collector.held_out.recall)} of those held out."
        )
    return " ".join(sentences)


def _expectations(checks: list[Check]) -> str:
    rows = [
        [check.claim, "holds" if check.holds else "**does not hold**", check.evidence]
        for check in checks
    ]
    return table(["What was expected", "Verdict", "Numbers"], rows, words=3)

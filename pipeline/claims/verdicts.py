"""What the paper claims (Sec. 3.3 and 5), each judged by the experiment."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from pipeline.claims import collecting, rules
from pipeline.claims.findings import (
    WORDS,
    Finding,
    Judge,
    Row,
    all_of,
    compare,
    exceeds,
    falls,
    opposite,
    rises,
    rises_or_is_full,
    unknown,
)
from pipeline.driving.metrics import METRICS
from pipeline.evaluation.comparison import Cell, naive
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.wording import in_condition
from pipeline.rollout.strategies import Strategy

type Rule = Callable[[Experiment], Finding]

NAIVE, SAFE = Strategy.NAIVE, Strategy.SAFE


@dataclass(frozen=True)
class Verdict:
    """A claim, what the data says to it, and the numbers that say so."""

    claim: str
    verdict: str
    """one of WORDS"""
    observed: str
    """what decides it, in a sentence"""
    evidence: str
    """all numbers"""


@dataclass(frozen=True)
class Claim:
    """Words, and how a verdict on them is found."""

    words: str
    runs: tuple[str, ...]
    """that it is about; none: whatever runs there are"""
    find: Rule

    def __call__(self, experiment: Experiment) -> Verdict:
        """Over the seeds that have the whole loop of all its runs; undecided where there is none."""
        seeds = [
            seed
            for seed in experiment.seeds
            if all(rules.is_whole(experiment, seed, run) for run in self.runs)
        ]
        names = " and ".join(map(experiment.title, self.runs)) or "any run"
        missing = f"no seed has iterations 0 to {experiment.last} of {names}"
        found = self.find(experiment.of_seeds(*seeds)) if seeds else unknown(missing)
        sentence = f"{found.observed[0].upper()}{found.observed[1:]}."
        return Verdict(self.words, WORDS[found.holds], sentence, found.evidence)


def verdicts(experiment: Experiment) -> list[Verdict]:
    """On every claim whose runs there are, in the order of the report."""
    present = set(experiment.runs)
    return [claim(experiment) for claim in claims(experiment) if present.issuperset(claim.runs)]


def claims(experiment: Experiment) -> list[Claim]:
    """All of them, in the order of the report: about SafeDAgger, each of its rivals and variants."""
    return [
        Claim(
            "The supervised primary, driven naively, fails on at least one test track.",
            (),
            rules.falls_short,
        ),
        Claim(
            "The safe strategy drives at least as far as the naive one, in every cell of run, "
            "iteration and condition.",
            (),
            rules.drives_as_far,
        ),
        *(_of_ours(experiment, experiment.ours) if experiment.ours else ()),
        *(
            Claim(
                f"{experiment.title(run)} learns without any catastrophic experience: while it collects, "
                "no drive leaves the road, touches a car or stands still.",
                (run,),
                partial(collecting.is_unharmed, run=run),
            )
            for run in experiment.strategies
            if experiment.specs[run].collects
        ),
    ]


def _of_ours(experiment: Experiment, ours: str) -> Iterator[Claim]:
    """What is claimed of SafeDAgger."""
    name, last, specs = experiment.title(ours), experiment.last, experiment.specs
    dagger, supervised = (
        [run for run, spec in specs.items() if spec.strategy == strategy]
        for strategy in ("dagger", "supervised")
    )
    variants = {run: specs[run] for run in experiment.variants if run != ours}
    yield Claim(
        f"From iteration 0 to {last} of {name}, the naive primary gets further, or does all laps, and "
        "under the safe strategy the reference drives less of the time.",
        (ours,),
        _improves(experiment, ours),
    )
    for rival in dagger[:1]:
        other = experiment.title(rival)
        yield Claim(
            f"Driven naively, {name}'s primary does {experiment.most(METRICS['laps']):g} laps on all test "
            f"tracks, in both conditions, within {last} iterations, and sooner than {other}'s.",
            (ours, rival),
            partial(rules.arrives_first, run=ours, rival=rival),
        )
        yield Claim(
            f"The naive primary's steering error falls in {name}, and faster than in {other}.",
            (ours, rival),
            _falls_faster(experiment, ours, rival, "steering_mse", NAIVE),
        )
        yield Claim(
            "Under the safe strategy, the share of the time that the reference drives falls in "
            f"{name}, and faster than in {other}.",
            (ours, rival),
            _falls_faster(experiment, ours, rival, "takeover", SAFE),
        )
    for variant, run in variants.items():
        if len(set(run.tau)) > 1:
            yield Claim(
                "A fixed tau is enough: with a rising one the naive primary gets no further.",
                (ours, variant),
                _not(_is_ahead(experiment, variant, ours)),
            )
    for rival in supervised:
        yield Claim(
            f"More data does not let supervised learning catch up: {name}'s naive primary gets "
            "further.",
            (ours, rival),
            _is_ahead(experiment, ours, rival),
        )
    yield Claim(
        "After supervised training, the reference drives more of the time with traffic than without, "
        "under the safe strategy (in the paper 10.81 % and 7.11 %).",
        (),
        _by_rows(
            Row(
                "with traffic against without",
                "takeover",
                Cell(ours, (0,), SAFE, ("traffic",)),
                Cell(ours, (0,), SAFE, ("no_traffic",)),
                rises,
            )
        ),
    )
    for variant, run in variants.items():
        if run.horizon:
            yield Claim(
                f"The same trend shows in {experiment.title(variant)}.",
                (variant,),
                _improves(experiment, variant),
            )
    for rival in dagger:
        as_many = specs[rival].frames == specs[ours].queries
        words = (
            f"queries to get as far, driven naively, than {experiment.title(dagger[0])} that was given as many."
            if as_many
            else f"queries than {experiment.title(rival)} to get as far, driven naively."
        )
        yield Claim(
            f"In the loop, without D_0 and D_safe, {name} needs fewer {words}",
            (ours, rival),
            partial(rules.needs_fewer_queries, run=ours, rival=rival),
        )
    for rival in dagger:
        if specs[rival].protocol == specs[ours].protocol:
            yield Claim(
                f"While collecting, {name} leaves the road, touches a car or stands still less often, "
                f"frame by frame, than {experiment.title(rival)}.",
                (ours, rival),
                partial(collecting.fails_less_often, run=ours, rival=rival),
            )


def _by_rows(*rows: Row) -> Rule:
    """Holds where all of them do."""

    def find(experiment: Experiment) -> Finding:
        found = [compare(experiment, row) for row in rows]
        return found[0] if len(found) == 1 else all_of(found)

    return find


def _not(rule: Rule) -> Rule:
    """Holds where the other does not."""
    return lambda experiment: opposite(rule(experiment))


def _improves(experiment: Experiment, run: str) -> Rule:
    """From iteration 0 to the last, in each condition, the naive laps surely rise or all drives do
    all in the end, and the takeover of safe surely falls.
    """
    last = experiment.last
    judged: tuple[tuple[str, Strategy, Judge], ...] = (
        ("laps", NAIVE, rises_or_is_full),
        ("takeover", SAFE, falls),
    )
    return _by_rows(
        *(
            Row(
                f"{in_condition(where)}, {metric} of {strategy}, iteration {last} against 0",
                metric,
                Cell(run, (last,), strategy, (where,)),
                Cell(run, (0,), strategy, (where,)),
                judge,
            )
            for where in experiment.conditions
            for metric, strategy, judge in judged
        )
    )


def _falls_faster(
    experiment: Experiment, run: str, rival: str, metric: str, strategy: Strategy
) -> Rule:
    """In each condition a metric of a run surely falls from iteration 0 to the last, and is surely
    lower in its loop, all iterations together, than in a rival's: both begin at the same iteration
    0, so that lower on the way is faster.
    """
    last, loop = experiment.last, tuple(range(1, experiment.last + 1))
    return _by_rows(
        *(
            Row(
                f"{in_condition(where)}, {words}",
                metric,
                Cell(run, iterations, strategy, (where,)),
                Cell(other, others, strategy, (where,)),
                falls,
            )
            for where in experiment.conditions
            for words, iterations, other, others in (
                (f"iteration {last} against 0", (last,), run, (0,)),
                (f"iterations 1 to {last} against {experiment.title(rival)}'s", loop, rival, loop),
            )
        )
    )


def _is_ahead(experiment: Experiment, run: str, other: str) -> Rule:
    """After the last iteration a run's naive laps, over all conditions, exceed another's: surely by
    more than 0, and not surely by MARGIN at most.
    """
    last, names = experiment.last, f"{experiment.title(run)} against {experiment.title(other)}"
    return _by_rows(
        Row(
            f"naive laps, {names}, iteration {last}",
            "laps",
            naive(experiment, run, last),
            naive(experiment, other, last),
            exceeds,
        )
    )

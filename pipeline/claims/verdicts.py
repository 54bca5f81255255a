"""What the paper claims (Sec. 3.3 and 5), each judged by the experiment."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

from pipeline.claims import rules
from pipeline.claims.findings import WORDS, Finding, opposite, unknown
from pipeline.claims.query_rule import needs_fewer_queries
from pipeline.evaluation.experiment import Experiment
from pipeline.evaluation.summary import LAPS
from pipeline.rollout.strategies import Strategy
from pipeline.runs import Run


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
    find: Callable[[Experiment], Finding]

    def __call__(self, experiment: Experiment) -> Verdict:
        """Over the seeds that have the whole loop of all its runs; undecided where there is none."""
        seeds = [
            seed
            for seed in experiment.seeds
            if all(rules.is_whole(experiment, seed, run) for run in self.runs)
        ]
        names = " and ".join(map(experiment.title, self.runs)) or "any run"
        missing = f"no seed has iterations 0 to {experiment.last} of {names}"
        found = self.find(experiment.only(seeds)) if seeds else unknown(missing)
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
    ]


def _of_ours(experiment: Experiment, ours: str) -> Iterator[Claim]:
    """What is claimed of SafeDAgger."""
    name, last, specs = experiment.title(ours), experiment.last, experiment.specs
    dagger, supervised = _rivals(specs, "dagger"), _rivals(specs, "supervised")
    variants = {run: specs[run] for run in experiment.variants if run != ours}
    yield Claim(
        f"From iteration 0 to {last} of {name}, the naive primary gets further, and under the safe "
        "strategy the reference drives less of the time.",
        (ours,),
        partial(rules.improves, run=ours),
    )
    for rival in dagger[:1]:
        other = experiment.title(rival)
        yield Claim(
            f"Driven naively, {name}'s primary does {LAPS:g} laps on all test tracks, in both "
            f"conditions, within {last} iterations, and sooner than {other}'s.",
            (ours, rival),
            partial(rules.arrives_first, run=ours, rival=rival),
        )
        for words, metric, strategy in (
            (
                f"The naive primary's steering error falls in {name}, and faster than in {other}.",
                "steering_mse",
                Strategy.NAIVE,
            ),
            (
                "Under the safe strategy, the share of the time that the reference drives falls in "
                f"{name}, and faster than in {other}.",
                "takeover",
                Strategy.SAFE,
            ),
        ):
            faster = partial(
                rules.falls_faster, run=ours, rival=rival, metric=metric, strategy=strategy
            )
            yield Claim(words, (ours, rival), faster)
    for variant, run in variants.items():
        if len(set(run.tau)) > 1:
            yield Claim(
                "A fixed tau is enough: with a rising one the naive primary gets no further.",
                (ours, variant),
                partial(_is_not_ahead, run=variant, other=ours),
            )
    for rival in supervised:
        yield Claim(
            f"More data does not let supervised learning catch up: {name}'s naive primary gets "
            "further.",
            (ours, rival),
            partial(rules.is_ahead, run=ours, other=rival),
        )
    yield Claim(
        "After supervised training, the reference drives more of the time with traffic than without, "
        "under the safe strategy (in the paper 10.81 % and 7.11 %).",
        (),
        partial(rules.takes_over_more_in_traffic, run=ours),
    )
    for variant, run in variants.items():
        if run.horizon:
            yield Claim(
                f"The same trend shows in {experiment.title(variant)}.",
                (variant,),
                partial(rules.improves, run=variant),
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
            partial(needs_fewer_queries, run=ours, rival=rival),
        )


def _is_not_ahead(experiment: Experiment, run: str, other: str) -> Finding:
    return opposite(rules.is_ahead(experiment, run, other))


def _rivals(specs: Mapping[str, Run], strategy: str) -> list[str]:
    """The runs of another strategy."""
    return [name for name, run in specs.items() if run.strategy == strategy]

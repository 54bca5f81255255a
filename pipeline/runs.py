"""What an experiment compares: its runs, a spec each.

A run is one training strategy, iteration after iteration. All begin with the same supervised stage,
iteration 0, whose step is called "0"; the others are <run>_<iteration>.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from pipeline.settings import listed

NAME = r"^[a-z]+[0-9]*(_[a-z]+[0-9]*)*$"
"""Of a run: its steps are its name, an underscore and a number."""

type Counts = list[Annotated[int, Field(ge=1)]]
"""Of each iteration, from the first."""

BUDGETS = {
    "supervised": ("episodes",),
    "dagger": ("frames", "sample"),
    "safedagger": ("queries",),
    "training": ("samples",),
}
"""By strategy, what a run has to be told for each iteration."""
OWN = {"safedagger": ("audit", "set_aside", "d_safe"), "dagger": ("beta", "ask")}
"""By strategy, what only its runs can be told."""
FIRST = "0"
"""The step that all runs begin with."""
BESIDE = ("tau", "scratch")
"""What stands in the place of a run in the names of steps beside the loops."""


class Run(BaseModel):
    """One run; it has as many iterations as its budgets. ValidationError where a key is unknown, missing
    or out of its range.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    strategy: Literal["supervised", "dagger", "safedagger", "training"]
    """how new data is collected: the reference alone; a mixture, all labelled; the safe strategy; or
    not at all, the training only goes on"""
    name: str
    """in the report"""
    words: str
    """what tells it apart, a sentence"""
    colour: str
    marker: str
    """of its lines in figures, as matplotlib knows them"""
    variant_of: str | None = None
    """the run that it is to be compared with; none for the strategies themselves"""

    queries: Counts = []
    """of safedagger: how often the reference is asked, audits too"""
    audit: Annotated[float, Field(ge=0, le=1)] = 0
    """of safedagger: share of the frames that the primary drives that are asked about whatever the
    safety policy says, and that the next one learns from"""
    set_aside: Annotated[float, Field(ge=0, lt=1)] = 0
    """of safedagger: share of the episodes of D_0 that no primary learns from, in the place of D_safe;
    0: there is a D_safe"""
    d_safe: Annotated[float, Field(gt=0, le=1)] = 1
    """of safedagger: share of the episodes of D_safe that there are for it"""
    frames: Counts = []
    """of dagger: how many are labelled, all that are driven"""
    ask: Annotated[float, Field(ge=0.01, le=1)] = 1
    """of dagger: or only this share of what the primary drives, at random"""
    sample: Counts = []
    """of dagger: how many of them are kept"""
    beta: Annotated[float, Field(ge=0, le=1)] = 0
    """of dagger: probability that the reference drives a frame"""
    episodes: Counts = []
    """of supervised: how many drives"""
    protocol: str = ""
    """how its drives begin and end while it collects: one of the comparison's"""

    samples: Counts
    """shown in the training of each iteration's primary; one for all"""
    tau: list[Annotated[float, Field(ge=0)]]
    """of the safety policies after iteration 0, 1, ...; one for all"""
    horizon: Annotated[float, Field(ge=0)] = 0
    """how far ahead these look [s]"""
    horizon_mode: Literal["last", "max"] = "last"
    learns: Literal["unsafe", "size"] = "unsafe"
    """whether a frame is unsafe, or how large its deviation is"""
    calibration: Annotated[float, Field(ge=0, lt=1)] = 0
    """share of the audits, or of D_safe before there are any, that tell how probable unsafe is"""
    cut: Annotated[float, Field(ge=0, le=1)] | None = None
    """below which safe probability they say unsafe; None: as train-safety is told for all"""
    driven_by: str = ""
    """driving strategies that its policies are evaluated by, separated by commas; none: only
    reliability is measured"""
    from_scratch: list[Annotated[int, Field(ge=1)]] = []
    """iterations whose primary is trained without a warm start, too"""

    @model_validator(mode="after")
    def _budgets(self) -> Self:
        needed = BUDGETS[self.strategy]
        for name in ("queries", "frames", "sample", "episodes"):
            given = len(getattr(self, name))
            if (name in needed) != bool(given):
                expected = "one for each iteration" if name in needed else "none"
                raise ValueError(f"{name} of a {self.strategy} run: {given} given, {expected}")
        for strategy, names in OWN.items():
            for name in names:
                usual = type(self).model_fields[name].default
                if getattr(self, name) != usual and self.strategy != strategy:
                    raise ValueError(
                        f"{name} of a {self.strategy} run, expected of {strategy} alone"
                    )
        if self.set_aside and self.has_own_d_safe:
            raise ValueError("set_aside is in the place of D_safe, expected no d_safe beside it")
        many = len(self.iterations)
        allowed = {"samples": (1, many), "tau": (1, many + 1)}
        for name, counts in {**allowed, **{name: (many,) for name in needed}}.items():
            given = len(getattr(self, name))
            if given not in counts:
                expected = " or ".join(map(str, dict.fromkeys(counts)))
                raise ValueError(f"{name}: {given} given, expected {expected}")
        for i, (driven, kept) in enumerate(zip(self.frames, self.sample, strict=True), 1):
            if kept > driven:
                raise ValueError(
                    f"sample: {kept} of iteration {i}, expected at most its {driven} frames"
                )
        if self.from_scratch and max(self.from_scratch) > many:
            raise ValueError(f"from_scratch: {max(self.from_scratch)}, expected {many} at most")
        return self

    @property
    def iterations(self) -> range:
        """Of its loop, from 1."""
        return range(1, len(getattr(self, BUDGETS[self.strategy][0])) + 1)

    @property
    def collects(self) -> bool:
        """Whether there is anything new to train on."""
        return self.strategy != "training"

    @property
    def is_watched(self) -> bool:
        """Whether its loop needs a safety policy; others have theirs, if any, to be measured."""
        return self.strategy == "safedagger"

    @property
    def needs_d_safe(self) -> bool:
        """Whether its loop needs a dataset for the safety policy alone."""
        return self.is_watched and not self.set_aside

    @property
    def has_own_d_safe(self) -> bool:
        """Whether that is a part of the one that others have."""
        return self.d_safe < 1

    @property
    def strategies(self) -> list[str]:
        """Those that its policies are evaluated by."""
        return listed(self.driven_by) if self.driven_by else []

    @property
    def told(self) -> dict[str, Any]:
        """What decides how it goes on: not how it is evaluated and shown."""
        beside = {"name", "words", "colour", "marker", "variant_of", "driven_by", "from_scratch"}
        return self.model_dump(exclude=beside)

    def shown(self, iteration: int) -> int:
        """Samples in the training of an iteration's primary."""
        return self.samples[iteration - 1] if len(self.samples) > 1 else self.samples[0]

    def asks(self, iteration: int) -> dict[str, Any]:
        """Options of rollout in an iteration: how much is asked."""
        audit = {"audit": self.audit} if self.audit else {}
        return {"queries": self.queries[iteration - 1]} | audit

    def labels(self, iteration: int) -> dict[str, Any]:
        """Options of train-safety after an iteration."""
        tau = self.tau[iteration] if len(self.tau) > 1 else self.tau[0]
        labels = {"tau": tau, "horizon": self.horizon, "horizon-mode": self.horizon_mode}
        own = self.model_dump(include={"learns", "calibration", "cut"}, exclude_defaults=True)
        return labels | own


class Reliability(BaseModel):
    """The scenarios in which the naive primaries are counted on, a drive in each: options of a task.

    Nothing may be chosen by how they do there.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    ends: str
    """of the supervised stage, and of each run's last iteration"""
    between: str | None = None
    """of the other iterations; none of them is driven where None"""
    crowded: str | None = None
    """of the ends again, in a crowd; none where None"""


class Comparison(BaseModel):
    """All runs by their names, the first of which sets the safety policy of the supervised stage.

    ValidationError where there is none; where one has a name of BESIDE, or is a variant, or of a
    protocol, that there is not; where several are trained from scratch; or where the first, whose
    supervised stage others share, sets something aside or has only a part of D_safe.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    runs: dict[Annotated[str, Field(pattern=NAME)], Run] = Field(min_length=1)
    protocols: dict[str, dict[str, Any]] = {}
    """how a drive that is recorded begins and ends: options of the task"""
    reliability: Reliability | None = None
    """None: it is not measured"""
    thresholds: list[Annotated[float, Field(gt=0, lt=1)]] = []
    """other tau that the supervised primary is watched with"""

    @model_validator(mode="after")
    def _relations(self) -> Self:
        for name, run in self.runs.items():
            if name in BESIDE:
                raise ValueError(f"{name}: names steps beside the runs, expected another name")
            if run.variant_of is not None and run.variant_of not in self.runs:
                raise ValueError(f"{name}: there is no run {run.variant_of!r} to be a variant of")
            if run.collects and run.protocol not in self.protocols:
                known = ", ".join(self.protocols) or "some in protocols"
                raise ValueError(f"{name}: protocol {run.protocol!r}, expected {known}")
        first, run = next(iter(self.runs.items()))
        if run.set_aside:
            raise ValueError(
                f"{first}: set_aside in the first run, expected all of D_0 in its place"
            )
        if run.has_own_d_safe:
            raise ValueError(f"{first}: d_safe in the first run, expected all of D_safe there")
        if sum(bool(run.from_scratch) for run in self.runs.values()) > 1:
            raise ValueError("from_scratch: given for several runs, expected one at most")
        return self

    @classmethod
    def of(cls, params: Mapping[str, Any]) -> Self:
        """What params.yaml says of it; a ValueError of one line otherwise."""
        given = {name: params[name] for name in cls.model_fields if name in params}
        try:
            return cls.model_validate(given)
        except ValidationError as error:
            first = error.errors()[0]
            place = ".".join(map(str, first["loc"])) or "runs"
            raise ValueError(f"{place}: {first['msg'].removeprefix('Value error, ')}") from None


def start(name: str, run: Run) -> str:
    """The step of a run's supervised stage: that of all, but where something of D_0 is set aside."""
    return f"{name}_0" if run.set_aside else FIRST


def safe_data(name: str, run: Run) -> str:
    """The step of the data that no primary of a run learns from, only its safety policies."""
    if run.has_own_d_safe:
        return f"safe_{name}"
    return f"safe_{start(name, run)}" if run.set_aside else "safe"


def read_params(path: Path) -> dict[str, Any]:
    """What is in params.yaml, or another file of names with values; FileNotFoundError where there is none,
    ValueError where it is no YAML.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file, expected YAML")
    try:
        content = yaml.safe_load(path.read_text())
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"{path}: {reason}, expected YAML") from None
    if not isinstance(content, dict):
        raise ValueError(f"{path}: expected names with values")
    return content

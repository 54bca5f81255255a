"""What a training is told. The defaults are those of params.yaml."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pipeline.registry import MEASURES
from pipeline.settings import Setting, Settings

LearningRate = Annotated[float, Setting("Above 0; for adamw the highest of the cycle.", above=0)]
WeightDecay = Annotated[float, Setting("Weight decay.", 0)]
Batch = Annotated[int, Setting("Examples in a step.", 1)]
Samples = Annotated[int, Setting("Examples shown in all, whatever the size of the dataset.", 1)]
"""Of both trainings, which differ in their defaults."""


@dataclass(frozen=True, kw_only=True)
class Optimisation(Settings):
    """How a network is fitted. The same for the primary and the safety policy.

    `sgd` is the paper's: momentum, and after each epoch that did not improve the validation error
    the rate is divided by 5; `patience` such epochs in a row end the training, and the weights with
    the lowest error are kept. `adamw` follows one cycle: the rate rises and falls back to zero
    within `samples`, and the last weights are kept. ValueError where a field is out of its range, or
    nothing is held out that `sgd` could follow.
    """

    optimizer: Annotated[
        Literal["sgd", "adamw"], Setting("sgd is the paper's, adamw one cycle of AdamW.")
    ] = "adamw"
    learning_rate: LearningRate = 0.002
    weight_decay: WeightDecay = 0.001
    batch: Batch = 32
    samples: Samples = 20_000
    validation: Annotated[
        float,
        Setting("Share of the episodes held out for the validation error, [0, 1).", 0, below=1),
    ] = 0.0
    patience: Annotated[int, Setting("For sgd: epochs without improvement before it stops.", 1)] = 3
    seed: Annotated[int, Setting("Of every random choice: equal seeds give equal bytes.", 0)] = 0
    threads: Annotated[
        int, Setting("Processor threads. Another number may give other last bits.", 1)
    ] = 2
    bfloat16: bool = True
    """Whether convolutions may be computed in bfloat16, on processors that can."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.optimizer == "sgd" and self.validation == 0:
            raise ValueError("validation is 0, expected more: 'sgd' follows the validation error")


@dataclass(frozen=True, kw_only=True)
class SafetySettings(Optimisation):
    """The training of a safety policy, and the labels that it learns; ValueError as `Optimisation`, or for
    'size' without a threshold.
    """

    learning_rate: LearningRate = 0.0001
    weight_decay: WeightDecay = 0.01
    batch: Batch = 64
    samples: Samples = 48_000

    tau: Annotated[float, Setting("Threshold on the deviation: safe up to here.", 0)] = 0.0025
    measure: Annotated[
        str,
        Setting(
            f"What deviates: {', '.join(MEASURES)}, or module:function; else what suits the primary."
        ),
    ] = ""
    horizon: Annotated[float, Setting("How far ahead to foresee a deviation [s].", 0)] = 0.0
    horizon_mode: Annotated[
        Literal["last", "max"],
        Setting("The deviation at the end of the horizon, or the largest within."),
    ] = "last"
    cut: Annotated[
        float, Setting("Unsafe is what has a lower probability of being safe.", 0, at_most=1)
    ] = 0.5
    learns: Annotated[
        Literal["unsafe", "size"],
        Setting("Whether a frame is unsafe, as the paper's, or how large its deviation is."),
    ] = "unsafe"
    balance: Annotated[
        float,
        Setting(
            "Class weights of 'unsafe': 0 counts each frame alike, 1 each class.", 0, at_most=1
        ),
    ] = 1.0
    held_out: Annotated[
        float, Setting("Share of D_safe's episodes kept to measure with.", above=0, below=1)
    ] = 0.2
    calibration: Annotated[
        float,
        Setting(
            "Share of the episodes of the last audits, or of the rest of D_safe without any, that it "
            "learns nothing from but how probable unsafe is; 0: none.",
            0,
            below=1,
        ),
    ] = 0.0
    hidden: Annotated[int, Setting("Width of each of the two hidden layers.", 1)] = 128

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.learns == "size" and self.tau == 0:
            raise ValueError("tau is 0, expected more: 'size' is that of a deviation, by tau")

    @property
    def kept(self) -> dict[str, Any]:
        """What a safety policy's configuration says, by the same names."""
        names = ("hidden", "tau", "cut", "measure", "horizon", "horizon_mode", "balance")
        return {name: getattr(self, name) for name in names}

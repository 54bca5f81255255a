"""What the car's drives are measured by (Sec. 4.4)."""

from pipeline.metric import DRIVEN, Metric

METRICS = {
    "laps": Metric(
        "Laps",
        "laps",
        "rounded down",
        "laps",
        most="laps",
        shown=("tables", "figures", "cards", "dvc"),
    ),
    "laps_iqm": Metric(
        "Interquartile mean of laps",
        "laps",
        "rounded down",
        "laps",
        statistic="interquartile mean",
        most="laps",
        strategies=("naive",),
        shown=("tables",),
    ),
    "damage_per_lap": Metric("Damage per lap", "m²/s² per lap", "amount", "damage", "laps"),
    "steering_mse": Metric(
        "Steering MSE",
        "squared error, full lock = 1",
        "amount",
        "deviation_sum",
        "primary_frames",
        strategies=("naive", "safe"),
    ),
    "takeover": DRIVEN["takeover"],
    "switches_per_lap": Metric(
        "Switches per lap",
        "switches",
        "amount",
        "switches",
        "laps",
        strategies=("safe", "optimal"),
        shown=("tables",),
    ),
    "takeover_length": DRIVEN["takeover_length"],
    "off_road": Metric("Left the road", "share of drives", "share", "off_road", shown=("cards",)),
}
CONDITIONS = {"no_traffic": "without traffic", "traffic": "with traffic"}
"""Those of `driving.task.Driving`, in words."""

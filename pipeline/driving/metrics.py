"""What the car's drives are measured by (Sec. 4.4)."""

from pipeline.metric import DRIVEN, FAILURE, Metric

FAILURES = {
    "road_left": "off_road",
    "touches": "touches",
    "stood_still": "(ended == 'stood still')",
}
"""Of `task.Task`."""

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
    "success": Metric(
        "Drives to the end without a failure",
        "share of drives",
        "share",
        "(ended == 'laps done') & (touches == 0)",
        strategies=("naive",),
        shown=("dvc",),
    ),
    "failures": Metric(
        "Failures per 100 km",
        "road left, touches, stood still",
        "amount",
        " + ".join(FAILURES.values()),
        "abs(distance_m) / 1e5",
        strategies=("naive",),
        shown=("dvc",),
    ),
    "off_road": Metric("Left the road", "share of drives", "share", "off_road", shown=("cards",)),
}
KINDS = {
    name: Metric(
        name.replace("_", " ").capitalize(), "times", "amount", FAILURE + name, statistic="mean"
    )
    for name in FAILURES
}
"""Of a loop up to an iteration: the failures of each kind."""
CONDITIONS = {"no_traffic": "without traffic", "traffic": "with traffic"}
"""Those of `driving.task.Driving`, in words."""

"""What the driving task adds to the core columns of a dataset, and how often a frame is recorded."""

from pipeline.data.schema import Feature, core_features

CONTROL_HZ = 30
"""Control steps per second of the world. A frame stands for k of them: a dataset's fps is 30 / k."""

STANDSTILL = 10.0
"""[s] without moving after which a drive is halted."""

SENSOR_RANGE = 60.0
"""[m] bumper to bumper: a distance with no car within it reads this."""

ROBOT_TYPE = "safedagger_car"
CAMERA = "observation.images.front"
IMAGE_SHAPE = (72, 160, 3)
ACTIONS = ("steering", "brake")
"""Steering [-1, 1], 1 being full lock to the left, and brake {0, 1}."""
LOW, HIGH = [-1.0, 0.0], [1.0, 1.0]
AFFORDANCES = (
    "lane_left",
    "lane_right",
    "car_left",
    "car_ahead",
    "car_right",
    "distance_left",
    "distance_ahead",
    "distance_right",
    "lane_position",
    "lane_angle",
)
"""The ten hidden variables of the paper's Appendix A, in its order."""
VEHICLE_STATE = ("x", "y", "heading", "speed")
"""Where our car is in the world [m, m, rad] and how fast [m/s]: to look at, no policy sees it."""


def _vector(names: tuple[str, ...]) -> Feature:
    return {"dtype": "float32", "shape": (len(names),), "names": list(names)}


FEATURES: dict[str, Feature] = {
    CAMERA: {"dtype": "image", "shape": IMAGE_SHAPE, "names": ["height", "width", "channel"]},
    **core_features({**_vector(ACTIONS), "low": LOW, "high": HIGH}),
    "affordances": _vector(AFFORDANCES),
    "vehicle_state": _vector(VEHICLE_STATE),
}
"""All columns of the car's datasets, as LeRobot describes them."""

DRIVEN = {name: FEATURES[name] for name in (CAMERA, "action")}
"""What a primary of the car sees and does."""
IMITATED = {**DRIVEN, "affordances": FEATURES["affordances"]}
"""What its training needs."""


def check_action_repeat(action_repeat: int) -> int:
    """Return the fps of a dataset in which a frame stands for `action_repeat` control steps.

    Raises:
        ValueError: `action_repeat` does not divide `CONTROL_HZ`; the fps would not be whole.
    """
    if action_repeat < 1 or CONTROL_HZ % action_repeat:
        raise ValueError(f"action_repeat is {action_repeat}, expected a divisor of {CONTROL_HZ}")
    return CONTROL_HZ // action_repeat

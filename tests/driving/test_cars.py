import numpy as np
import pytest

from pipeline.driving.cars import DT, LOCK, STEERING_LAG, THROTTLE_MAX, WHEELBASE, Cars, move
from pipeline.driving.reference import BRAKE_TIME
from pipeline.driving.tracks import Track
from pipeline.driving.traffic import SPEED_LIMIT
from tests.driving.scenes import cars_at

COAST, BRAKE = np.array([[0.0, 0.0]]), np.array([[0.0, 1.0]])


def path(cars: Cars, track: Track, action: np.ndarray, steps: int) -> np.ndarray:
    """[steps, 2] (m) where car 0 comes by."""
    points = []
    for _ in range(steps):
        move(cars, action, track)
        points.append((cars.x[0], cars.y[0]))
    return np.array(points)


@pytest.mark.parametrize("steering", [1.0, 0.3, -0.3, -1.0])
@pytest.mark.parametrize("speed", [3.0, 20.0])
def test_a_constant_wheel_angle_drives_a_circle_of_the_bicycle_model(
    alder: Track, steering: float, speed: float
) -> None:
    cars = cars_at(alder, [0.0], [1], limit=speed)
    wheel = steering * LOCK
    cars.wheel[:] = wheel
    rear_axle = WHEELBASE / np.tan(abs(wheel))
    radius = np.hypot(rear_axle, WHEELBASE / 2)
    steps = round(np.pi * radius / speed / DT)  # half round
    x, y = path(cars, alder, np.array([[steering, 0.0]]), steps).T
    # x^2 + y^2 = 2 a x + 2 b y + c for a circle around (a, b)
    a, b, c = np.linalg.lstsq(np.stack([2 * x, 2 * y, 1 + 0 * x], axis=1), x**2 + y**2)[0]
    assert np.sqrt(c + a**2 + b**2) == pytest.approx(radius, rel=0.005)
    left = (x[1] - x[0]) * (y[2] - y[1]) - (y[1] - y[0]) * (x[2] - x[1])
    assert np.sign(left) == np.sign(steering)


def test_twenty_metres_a_second_for_two_seconds_is_forty_metres(alder: Track) -> None:
    cars = cars_at(alder, [0.0], [1], limit=20.0)
    start = np.array([cars.x[0], cars.y[0]])
    end = path(cars, alder, COAST, round(2 / DT))[-1]
    assert np.hypot(*(end - start)) == pytest.approx(40.0)


def test_the_brake_stops_within_the_gap_at_which_the_reference_brakes(alder: Track) -> None:
    cars = cars_at(alder, [0.0], [1], limit=SPEED_LIMIT)
    start = np.array([cars.x[0], cars.y[0]])
    end = path(cars, alder, BRAKE, round(5 / DT))[-1]
    assert cars.speed[0] == 0.0
    assert np.hypot(*(end - start)) < BRAKE_TIME * SPEED_LIMIT


@pytest.mark.parametrize("speed", [0.0, 10.0, 25.0])
def test_the_governor_holds_the_limit(alder: Track, speed: float) -> None:
    cars = cars_at(alder, [0.0], [1], limit=SPEED_LIMIT)
    cars.speed[:] = speed
    before = cars.speed.copy()
    for _ in range(round(20 / DT)):
        move(cars, COAST, alder)
        assert abs(cars.speed[0] - before[0]) <= THROTTLE_MAX * DT + 1e-9
        assert np.sign(SPEED_LIMIT - speed) * (SPEED_LIMIT - cars.speed[0]) >= -1e-9
        before = cars.speed.copy()
    assert cars.speed[0] == pytest.approx(SPEED_LIMIT, abs=0.01)


def test_the_wheels_lag_behind_their_command(alder: Track) -> None:
    cars = cars_at(alder, [0.0], [1])
    steps = round(STEERING_LAG / DT)
    path(cars, alder, np.array([[1.0, 0.0]]), steps)
    part = 1 - np.exp(-steps * DT / STEERING_LAG)
    assert cars.wheel[0] == pytest.approx(part * LOCK)
    for command in (1.0, -7.0):  # as far as the lock lets them
        path(cars, alder, np.array([[command, 0.0]]), 60)
        assert cars.wheel[0] == pytest.approx(np.sign(command) * LOCK)


def test_cars_do_not_touch_each_others_state(alder: Track) -> None:
    alone, both = cars_at(alder, [0.0], [1]), cars_at(alder, [0.0, 30.0], [1, 0])
    path(alone, alder, np.array([[0.2, 0.0]]), 30)
    path(both, alder, np.array([[0.2, 0.0], [-0.5, 1.0]]), 30)
    for name in ("x", "y", "heading", "speed", "wheel", "s", "d"):
        assert getattr(alone, name)[0] == pytest.approx(getattr(both, name)[0])


def test_the_angle_to_the_lane_is_that_of_placement(alder: Track) -> None:
    cars = cars_at(alder, [0.0, 100.0, 700.0], [0, 1, 2], angle=[0.2, -0.2, 3.0])
    np.testing.assert_allclose(cars.angle(alder), [0.2, -0.2, 3.0], atol=1e-9)

"""Simulation beside its floors: the closed loop, workers, traffic, a new drive, other simulators. What
the floor of the closed loop has none of is mostly the reference, which drives all other cars too.

python -m benchmarks.simulation
"""

import copy
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from statistics import median
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium import Env

from benchmarks.timing import Row, paired, seconds, shares, table
from pipeline.driving import camera
from pipeline.driving.cars import Cars, move
from pipeline.driving.environment import DrivingEnv
from pipeline.driving.features import CAMERA, CONTROL_HZ
from pipeline.driving.network import PrimaryNetwork
from pipeline.driving.reference import reference_actions
from pipeline.driving.task import Driving
from pipeline.driving.tracks import make_track
from pipeline.driving.world import World
from pipeline.evaluation.driving import Trial, evaluate
from pipeline.policies.inference import Driver
from pipeline.policies.network import CHANNELS, SafetyNetwork
from pipeline.rollout.plans import Plan, driven
from pipeline.rollout.rules.safe import Safe
from pipeline.rollout.workers import in_order

TRACK = "spruce"
SECONDS = 10.0  # of a drive
STEPS = 60  # of a control step each, two seconds
DRIVES = 6  # spread over workers
DRIVE = {
    "pipeline/driving/world.py:image": "placing the cars, and the camera",
    "pipeline/policies/inference.py:act": "the networks",
    "pipeline/driving/reference.py:reference_actions": "the reference, of all cars in each step",
    "pipeline/driving/world.py:step": "moving them, and who touches whom",
    "pipeline/driving/world.py:affordances": "affordances",
}
"""What a drive does in each frame."""


def rows() -> Iterator[Row]:
    """All rows."""
    yield closed_loop(12, CHANNELS // 2, "12 cars, half the paper's network")
    yield closed_loop(40, CHANNELS, "40 cars, the paper's network")
    drive = partial(evaluate, _trial(40), _driver(CHANNELS))
    yield from shares("of the second", drive, DRIVE)
    for traffic in (12, 40):
        yield traffic_step(traffic)
    yield new_drive()
    yield two_workers()
    yield from peers()


def closed_loop(traffic: int, channels: int, which: str) -> Row:
    """A frame of an evaluation, beside placing the cars, the camera and the networks alone."""
    driver, trial = _driver(channels), _trial(traffic)
    states = _states(trial.plan)
    times = paired(
        partial(_work, evaluate, [(trial, driver)]),
        partial(_work, _see_and_act, [(states, driver)]),
    )
    return Row.timed(
        f"closed loop, {which}, against camera and networks alone",
        times,
        1e3 / len(states),
        "ms a frame",
        f"at most {1 / 0.85:.2f}",
    )


def traffic_step(traffic: int) -> Row:
    """A frame's three control steps of all cars, each with the reference, beside the camera."""
    states = _states(_trial(traffic).plan)
    times = paired(
        partial(_work, _move_on, [(states,)]), partial(_work, _see_and_act, [(states, None)])
    )
    what = f"traffic, {traffic} cars and three steps a frame, against the camera alone"
    return Row.timed(what, times, 1e3 / len(states), "ms a frame")


def new_drive() -> Row:
    """A reset on the same track, beside a frame."""
    env = DrivingEnv(track=TRACK, traffic=12, action_repeat=3)
    env.reset(seed=0)

    def steps() -> None:
        for _ in range(20):
            env.step(env.label())

    def resets() -> None:
        for seed in range(20):
            env.reset(seed=seed)

    ours, floor, ratio = paired(resets, steps)
    env.close()
    what = "new drive on the same track, its first picture with it, against a frame"
    return Row(what, ours * 50, floor * 50, "ms", ratio)


def two_workers() -> Row:
    """How much faster two workers are than one: in an evaluation, and in rendering alone."""
    driver, trial = _driver(CHANNELS // 2), _trial(12)
    jobs = [(trial, driver)] * DRIVES
    states = [(_states(trial.plan), None)] * DRIVES
    turns = [(_gain(evaluate, jobs), _gain(_see_and_act, states)) for _ in range(6)][1:]
    return Row(
        "two workers against one, and rendering alone likewise",
        median(ours for ours, _ in turns),
        median(floor for _, floor in turns),
        "times as fast",
        median(ours / floor for ours, floor in turns),
        "at least 1",
    )


def peers() -> Iterator[Row]:
    """A control step with its picture, beside one of what a user might take instead."""
    for name, module, traffic, make, action in (
        ("Gymnasium's CarRacing-v3, 96x96 pixels", "Box2D", 0, _car_racing, lambda: np.zeros(3)),
        ("HighwayEnv, as many cars and pixels", "highway_env", 12, _highway, lambda: 1),
    ):
        what = f"control step with picture, {traffic} cars, against {name}"
        if not find_spec(module):
            yield Row(f"{what} (not installed: {module})", np.nan, np.nan, "", np.nan)
            continue
        own, other = DrivingEnv(track=TRACK, traffic=traffic), make()
        for env in (own, other):
            env.reset(seed=0)
        ours, floor, ratio = paired(partial(_steps, own, own.label), partial(_steps, other, action))
        own.close()
        other.close()
        yield Row(what, ours * 1e3 / STEPS, floor * 1e3 / STEPS, "ms", ratio)


def _car_racing() -> Env[Any, Any]:
    return gymnasium.make("CarRacing-v3")


def _highway() -> Env[Any, Any]:
    gymnasium.register_envs(import_module("highway_env"))
    grey = {"type": "GrayscaleObservation", "observation_shape": (160, 72), "stack_size": 1}
    config = {
        "observation": grey | {"weights": [0.2989, 0.5870, 0.1140]},
        "vehicles_count": 12,
        "simulation_frequency": CONTROL_HZ,
        "policy_frequency": CONTROL_HZ,
    }
    return gymnasium.make("highway-v0", config=config)


def _steps(env: Env[Any, Any], action: Callable[[], Any]) -> None:
    for _ in range(STEPS):
        _, _, terminated, truncated, _ = env.step(action())
        if terminated or truncated:
            env.reset(seed=0)


def _driver(channels: int) -> Driver:
    generator = torch.Generator().manual_seed(0)
    primary = PrimaryNetwork(channels, generator=generator)
    return Driver(primary, SafetyNetwork(primary.feature_size, 128, generator=generator))


def _trial(traffic: int) -> Trial:
    """A drive in which the policies look at each frame, but the reference drives: all go as far."""
    task = Driving(tracks=TRACK, traffic=traffic, seconds=SECONDS)
    return Trial(Plan(task, TRACK, Safe(1.0), (0, 1000, 0)), "traffic", {}, 0)


def _states(plan: Plan) -> list[Cars]:
    """Of each frame of a drive."""
    return [copy.deepcopy(env.world.cars) for env, _ in driven(plan, None)]  # type: ignore[attr-defined]


def _see_and_act(states: list[Cars], driver: Driver | None) -> None:
    with World(
        make_track(TRACK), len(states[0]) - 1, (0.0, 0.0), np.random.default_rng(0)
    ) as world:
        for cars in states:
            world.scene.place(cars)
            world.scene.focus(float(cars.s[0]))
            image = camera.render(world.scene, cars.x[0], cars.y[0], cars.heading[0])
            if driver:
                driver.act({CAMERA: image})


def _move_on(states: list[Cars]) -> None:
    track, cars = make_track(TRACK), copy.deepcopy(states[0])
    for _ in range(3 * len(states)):
        move(cars, reference_actions(cars, track), track)


def _gain(job: Callable[..., object], jobs: list[tuple]) -> float:
    one, two = (seconds(partial(_work, job, jobs, workers)) for workers in (1, 2))
    return one / two


def _work(job: Callable[..., object], jobs: list[tuple], workers: int = 1) -> None:
    for _ in in_order(job, jobs, workers):
        pass


if __name__ == "__main__":
    print(table(rows()))

"""One drive: cars on a track, who hits whom, how far ours has come."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pipeline.driving import camera
from pipeline.driving.affordances import affordances
from pipeline.driving.cars import Cars, move
from pipeline.driving.scene import borrow, give_back
from pipeline.driving.tracks import Track
from pipeline.driving.traffic import Begins, start

RELEASE = 0.3  # [m/s] that a bumped car is left moving apart from ours
TOUCH = 15  # control steps, half a second: contacts with a car no further apart are one touch


class World:
    """The true state of a drive. Car 0 is ours. Use as a context manager, or call `close`: then the
    next drive on this track has its scene.
    """

    def __init__(
        self,
        track: Track,
        traffic: int,
        spread: tuple[float, float],
        rng: np.random.Generator,
        *,
        begins: Begins = "anywhere",
    ) -> None:
        """A drive with `traffic` other cars; our car starts off its lane by `spread` (standard
        deviations in m and rad), anywhere or on the start line.

        Raises:
            ValueError: the track has no room for so many cars.
        """
        self.track = track
        self.cars: Cars = start(track, traffic, spread, rng, begins=begins)
        self.scene = borrow(track, len(self.cars))
        self.scene.place(self.cars)
        self._placed = True
        self.damage = 0.0
        """[m^2/s^2] the sum of half the squared speed of each touch of our car: energy per mass"""
        self.touches = 0
        """how often our car touched another"""
        self._start = float(self.cars.s[0])
        self._steps = 0
        self._contacts: dict[int, tuple[int, float]] = {}
        """car -> step of its last contact with ours, damage that this touch has done so far"""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """The drive is over."""
        give_back(self.scene)

    @property
    def laps(self) -> float:
        """Laps driven by our car, fractional; negative where it drove backwards."""
        return self.distance / self.track.length

    @property
    def distance(self) -> float:
        """[m] driven along the road by our car; negative where it drove backwards."""
        return float(self.cars.s[0]) - self._start

    @property
    def off_road(self) -> bool:
        """Whether the middle of our car has left the asphalt, or the car has turned off the road's
        direction altogether.
        """
        return bool(
            abs(self.cars.d[0]) > self.track.half_width
            or abs(self.cars.angle(self.track, 1)[0]) > 0.5 * np.pi
        )

    def image(self) -> NDArray[np.uint8]:
        """What our camera sees: uint8 [72, 160, 3]."""
        self._place()
        self.scene.focus(float(self.cars.s[0]))
        return camera.render(self.scene, self.cars.x[0], self.cars.y[0], self.cars.heading[0])

    def affordances(self) -> NDArray[np.float32]:
        """[10], see `affordances.affordances`."""
        return affordances(self.cars, self.track)

    def vehicle_state(self) -> NDArray[np.float32]:
        """[4] our car's position x, y [m], heading [rad] and speed [m/s]."""
        cars = self.cars
        return np.array([cars.x[0], cars.y[0], cars.heading[0], cars.speed[0]], np.float32)

    def step(self, actions: NDArray[np.floating]) -> None:
        """Advance by one control step; `actions` is [N, 2], every car's steering in [-1, 1] and
        brake.

        Raises:
            ValueError: an action is NaN or infinite.
        """
        if not np.isfinite(actions).all():
            car = int(np.flatnonzero(~np.isfinite(actions).all(axis=1))[0])
            raise ValueError(f"action of car {car} is {actions[car]}, expected finite numbers")
        move(self.cars, actions, self.track)
        self._placed = False
        self._steps += 1
        if self._is_near_another():
            self._place()
            for other, normal, overlap in self.scene.contacts():
                self._collide(other, normal, overlap)

    def _place(self) -> None:
        """Where somebody looks: to where the cars came by themselves. One that is pushed aside is
        seen where it was hit, until the next step.
        """
        if not self._placed:
            self.scene.place(self.cars)
            self._placed = True

    def _is_near_another(self) -> bool:
        """Spares the collision detection, nearly always."""
        cars = self.cars
        return bool(np.any(np.hypot(cars.x[1:] - cars.x[0], cars.y[1:] - cars.y[0]) < 6.0))

    def _collide(self, other: int, normal: NDArray[np.float64], overlap: float) -> None:
        """A plastic impact: count its damage, share the speed along the push, and part the cars."""
        cars = self.cars
        directions = np.stack(
            [np.cos(cars.heading[[0, other]]), np.sin(cars.heading[[0, other]])], axis=1
        )
        ours, theirs = cars.speed[[0, other], None] * directions
        closing = -float((ours - theirs) @ normal)
        self._count_damage(other, 0.5 * max(closing, 0.0) ** 2)
        if abs(normal @ directions[0]) > 0.5:  # bumper to bumper, not side by side
            front, rear = (other, 0) if normal @ directions[0] < 0 else (0, other)
            shared = 0.5 * (cars.speed[0] + cars.speed[other])
            cars.speed[front] = max(cars.speed[front], shared + RELEASE)
            cars.speed[rear] = min(cars.speed[rear], max(shared - RELEASE, 0.0))
        for car, way in ((0, 0.5), (other, -0.5)):
            cars.x[car] += way * overlap * normal[0]
            cars.y[car] += way * overlap * normal[1]

    def _count_damage(self, other: int, energy: float) -> None:
        """A touch may last, or come and go, for many steps: it counts once, by its hardest moment."""
        last, counted = self._contacts.get(other, (-TOUCH, 0.0))
        if self._steps - last > TOUCH:
            counted = 0.0
            self.touches += 1
        self.damage += max(energy - counted, 0.0)
        self._contacts[other] = (self._steps, max(energy, counted))

"""What can be drawn, and what a drive has come to: as it is counted while it is driven."""

from dataclasses import replace

import pytest

from pipeline.inspection.drawn import Tally, drawn, track_to_draw
from pipeline.policies.inference import Driver
from pipeline.rollout.plans import Plan
from pipeline.rollout.rules.mixture import Mixture
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.reference import Reference
from tests.drives import plan
from tests.stages.pendulum import Pendulum

PLAN = plan(Mixture(0.7), track="birch", seed=(3,), seconds=3.0)
ALONE = replace(PLAN, rule=Reference())


def test_the_tally(driver: Driver) -> None:
    tallies, drove = [], []
    for world, frame, tally in drawn(PLAN, driver):
        assert (tally.laps, tally.damage) == (world.laps, world.damage)
        tallies.append(tally)
        drove.append(frame.intervention)
    assert [tally.frames for tally in tallies] == list(range(1, 31))
    assert tally.by_reference == sum(drove)
    before = [False, *drove[:-1]]
    began = [now and not was for was, now in zip(before, drove, strict=True)]
    assert tally.takeovers == sum(began)
    assert 1 < tally.takeovers < tally.by_reference < 30
    assert f"{world.laps:.2f} laps" in str(tally) and f"{tally.takeovers} takeovers" in str(tally)


def test_the_reference_alone_takes_over_from_nobody() -> None:
    *_, (_, _, tally) = drawn(ALONE, None)
    assert (tally.by_reference, tally.takeovers) == (30, 0)


@pytest.mark.parametrize(
    ("plan", "ended"),
    [
        (ALONE, "out of time"),
        (replace(ALONE, task=replace(PLAN.task, laps=0.02)), "laps done"),
        (replace(PLAN, rule=Naive(), task=replace(PLAN.task, seconds=99)), "road left"),
    ],
)
def test_a_drive_says_why_it_ended_once_it_has(plan: Plan, ended: str, driver: Driver) -> None:
    *before, last = [tally for _, _, tally in drawn(plan, driver)]
    assert not any("ended" in str(tally) for tally in (Tally(), *before))
    assert str(last).endswith(f"; ended: {ended}")


def test_what_is_done_of_a_drive_is_of_its_time_or_of_its_laps() -> None:
    by_time = [tally.done for _, _, tally in drawn(ALONE, None)]
    assert by_time == pytest.approx([number / 30 for number in range(1, 31)])
    short = replace(ALONE, task=replace(PLAN.task, laps=0.02, seconds=99))
    *before, last = [tally for _, _, tally in drawn(short, None)]
    assert last.done == 1 and all(tally.done == tally.laps / 0.02 < 1 for tally in before)


def test_only_one_track_of_the_car_is_drawn() -> None:
    assert track_to_draw(PLAN.task).name == "birch"
    with pytest.raises(ValueError, match="tracks is 'birch,alder', expected a single one"):
        track_to_draw(replace(PLAN.task, tracks="birch,alder"))
    pendulum = Pendulum(length=1.0)
    with pytest.raises(ValueError, match=r"Pendulum', expected one that can be drawn: driving"):
        track_to_draw(pendulum)
    with pytest.raises(ValueError, match="expected one that can be drawn"):
        next(drawn(Plan(pendulum, "hold up", Reference(), (0,)), None))

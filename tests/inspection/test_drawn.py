"""What is seen of a drive while it is driven: what a recording of it would hold; and its tally."""

import time
from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from pipeline.driving.features import CAMERA
from pipeline.driving.tracks import make_track
from pipeline.inspection.drawn import Tally, drawn, in_real_time, plan_to_draw, watched
from pipeline.inspection.footage import Footage
from pipeline.inspection.rerun_blueprints import live_blueprint
from pipeline.inspection.rerun_log import drive_tracer, new_recording
from pipeline.inspection.rerun_sinks import into_file
from pipeline.inspection.rerun_traces import RAW
from pipeline.policies.inference import Driver
from pipeline.rollout.judgement import Judgement
from pipeline.rollout.plans import Plan, stream
from pipeline.rollout.recording import record
from pipeline.rollout.rules.mixture import Mixture
from pipeline.rollout.rules.naive import Naive
from pipeline.rollout.rules.reference import Reference
from pipeline.rollout.strategies import Strategy
from tests.drives import plan
from tests.inspection.saved import batches, column, origins, recordings
from tests.stages.pendulum import Pendulum

PLAN = plan(Mixture(0.7), track="birch", traffic=30, seed=(3,), seconds=3.0)
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
    alone = Strategy.REFERENCE, None, 3
    assert plan_to_draw(PLAN.task, *alone) == replace(ALONE, seed=(3, stream("film")))
    with pytest.raises(ValueError, match="tracks is 'birch,alder', expected a single one"):
        plan_to_draw(replace(PLAN.task, tracks="birch,alder"), *alone)
    pendulum = Pendulum(length=1.0)
    with pytest.raises(ValueError, match=r"Pendulum', expected one that can be drawn: driving"):
        plan_to_draw(pendulum, *alone)
    with pytest.raises(ValueError, match="expected one that can be drawn"):
        next(drawn(Plan(pendulum, "hold up", Reference(), (0,)), None))


def test_every_frame_is_as_recorded(driver: Driver) -> None:
    recording = record(PLAN, driver, 0, 0)
    expected = Footage.of_episode(recording.episode)
    seen = [footage for footage, _ in watched(PLAN, driver)]
    assert len(seen) == len(expected) == 30
    for number, footage in enumerate(seen):
        for name in ("frame", "image", "primary_action", "intervention", "vehicle_state"):
            values = getattr(expected, name)[number : number + 1]
            np.testing.assert_array_equal(getattr(footage, name), values, err_msg=name)
        action = recording.reference_actions[number : number + 1]
        np.testing.assert_array_equal(footage.reference_action, action)
        np.testing.assert_array_equal(footage.queried, footage.intervention)
    for before, after in pairwise(seen):
        np.testing.assert_array_equal(before.end, after.vehicle_state[:, :2])


def test_all_other_cars_are_where_they_were_when_the_frame_began() -> None:
    plan = replace(PLAN, rule=Reference())
    before = np.empty((0, 3))
    for (footage, _), (world, *_) in zip(watched(plan, None), drawn(plan, None), strict=True):
        (others,) = footage.others
        np.testing.assert_array_equal(others, before)
        cars = world.cars
        before = np.stack([cars.x[1:], cars.y[1:], cars.heading[1:]], axis=1)
    assert len(before) == 30


def test_a_whole_drive(driver: Driver) -> None:
    seen = [footage for footage, _ in watched(PLAN, driver)]
    whole = Footage.joined(seen)
    assert len(whole) == len(whole.others) == 30
    for number, footage in enumerate(seen):
        again = whole.rows(number, number + 1)
        for each in fields(Footage):
            np.testing.assert_array_equal(getattr(again, each.name), getattr(footage, each.name))


def test_real_time_is_waited_for_and_never_made_up() -> None:
    begin = time.monotonic()
    due = [time.monotonic() - begin for _ in in_real_time(iter(range(4)), 50)]
    assert all(at >= number / 50 for number, at in enumerate(due))
    assert list(in_real_time(iter("late"), 1e9)) == list("late")


def test_frame_by_frame_gives_what_is_there_at_the_end(driver: Driver, tmp_path: Path) -> None:
    path, fps = tmp_path / "live.rrd", PLAN.task.fps
    seen = [footage for footage, _ in watched(PLAN, driver)]
    with (
        into_file(path, live_blueprint(fps)) as sink,
        new_recording("live", "Live", make_track(PLAN.scenario), sink.connect) as recording,
    ):
        send = drive_tracer(
            recording, fps=fps, judgement=Judgement(0.5, 0.01, "steering"), camera=RAW
        )
        for footage in seen:
            send(footage)
    (entry,) = recordings(path)
    images = record(PLAN, driver, 0, 0).episode.columns[CAMERA]
    buffers = column(path, entry, "/camera", "buffer")
    for buffer, image in zip(buffers, images, strict=True):
        assert bytes(buffer) == image.tobytes()
    others = batches(path, entry, "/top_view/others", "strips")
    assert [len(strips) for strips in others] == [0] + [30] * 29
    drives = np.array(column(path, entry, "/safe_probability/reference_drives", "scalars"))
    assert (~np.isnan(drives)).tolist() == [bool(footage.intervention[0]) for footage in seen]
    assert not origins(path) & {"who", "around"}

"""A policy of LeRobot's as the primary: ACT, small and untrained, in the world of a pendulum."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import torch
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors

from pipeline.data.dataset import Dataset
from pipeline.data.images import read_all
from pipeline.driving.task import Driving
from pipeline.policies.computing import find_device
from pipeline.policies.inference import Driver, propose
from pipeline.policies.loading import load_primary
from pipeline.policies.network import SafetyNetwork
from pipeline.rollout.recording import record_all
from pipeline.rollout.rules.mixture import Mixture
from pipeline.rollout.rules.naive import Naive
from tests.command import run
from tests.devices import DEVICES
from tests.policies.acting import MEAN, STD, frame
from tests.stages.pendulum import Pendulum
from tests.stages.test_another_world import DRIVEN, SAFETY, collect


def selected(act: Path, policy: ACTPolicy, frames: list[dict[str, np.ndarray]]) -> np.ndarray:
    """What LeRobot's own code does in these frames, one after the other: [T, A]."""
    before, after = make_pre_post_processors(policy.config, pretrained_path=str(act))
    done = []
    for seen in frames:
        batch = {
            "observation.image": torch.from_numpy(seen["observation.image"]).permute(2, 0, 1)[None]
            / 255,
            "observation.state": torch.from_numpy(seen["observation.state"])[None],
        }
        with torch.no_grad():
            done.append(after(policy.select_action(before(batch)))[0].numpy())
    return np.stack(done)


def test_it_does_what_lerobots_own_code_does(act: Path) -> None:
    """Normalised before, brought back to the scale of the actions behind."""
    policy = ACTPolicy.from_pretrained(act).eval()
    seen = frame()
    (expected,) = selected(act, policy, [seen])
    action, _ = Driver.load(act).act(seen)
    np.testing.assert_allclose(action, expected, rtol=1e-5)
    looked = load_primary(act).look(
        {n: torch.from_numpy(column)[None] for n, column in seen.items()}
    )
    assert looked.shape == (1, 32 + 1)
    # the features are what the first action is a linear function of
    head = policy.get_submodule("model.action_head")
    np.testing.assert_allclose(
        head(looked[:, :32].clone()).detach().numpy() * STD + MEAN, action[None], rtol=1e-4
    )


def test_each_frame_is_asked_anew(act: Path) -> None:
    """No queue holds actions from before a takeover."""
    driver, seen = Driver.load(act), frame()
    first, _ = driver.act(seen)
    driver.act({**seen, "observation.state": seen["observation.state"] + 9})
    again, _ = driver.act(seen)
    np.testing.assert_array_equal(first, again)


def test_a_chunk_is_held_as_lerobots_own_code_holds_it(act: Path) -> None:
    policy = ACTPolicy.from_pretrained(act).eval()
    policy.config.n_action_steps = 3
    policy.reset()
    frames = [frame(seed) for seed in range(7)]
    anew, held = (
        np.stack([driver.act(seen)[0] for seen in frames])
        for driver in (Driver.load(act), Driver.load(act, hold=3))
    )
    np.testing.assert_allclose(held, selected(act, policy, frames), rtol=1e-5)
    np.testing.assert_array_equal((held == anew)[:, 0], [n % 3 == 0 for n in range(7)])


def test_the_safety_policy_sees_each_frame_and_the_action_that_is_done_in_it(act: Path) -> None:
    actor = load_primary(act)
    safety = SafetyNetwork(33, 4, generator=torch.Generator().manual_seed(0)).eval()
    driver = Driver(actor, safety, hold=2)
    driver.act(frame(0))
    action, signals = driver.act(frame(1))
    looked = actor.look({name: torch.from_numpy(of)[None] for name, of in frame(1).items()})
    with torch.inference_mode():
        fresh, held = (
            float(safety(torch.cat([looked[:, :32], done], 1)).softmax(1)[0, 1])
            for done in (looked[:, 32:], torch.from_numpy(action)[None])
        )
    assert signals == {"safe_probability": held} != {"safe_probability": fresh}


def test_no_plan_outlives_a_frame_that_the_reference_drove(act: Path) -> None:
    driver, world = Driver.load(act, hold=5), Pendulum(length=1.5)
    (driven,) = record_all(world, Mixture(0.3), driver, [0], seed=(1,), iteration=1, workers=1)
    columns = driven.episode.columns
    anew, _ = propose(load_primary(act), columns)
    expected, plan = [], 0
    for drove in columns["intervention"][:, 0]:
        expected.append(plan % 5 == 0)
        plan = 0 if drove else plan + 1
    assert 1 < sum(expected) < len(expected)
    np.testing.assert_array_equal(
        np.isclose(columns["primary_action"], anew, rtol=1e-5)[:, 0], expected
    )


@pytest.mark.parametrize("name", DEVICES)
def test_it_drives_alike_on_each_device_whichever_it_was_trained_on(
    act: Path, name: str, tmp_path: Path
) -> None:
    """A policy says in two of its files on which it was trained: here on a GPU."""
    shutil.copytree(act, tmp_path / "act")
    for file in ("config.json", "policy_preprocessor.json"):
        text = (act / file).read_text()
        assert text.count('"device": "cpu"') == 1
        (tmp_path / "act" / file).write_text(text.replace('"device": "cpu"', '"device": "cuda"'))
    expected, driver = (
        Driver.load(path, hold=2, device=find_device(device))
        for path, device in ((act, "cpu"), (tmp_path / "act", name))
    )
    assert driver.primary.device.type == name
    for seed in range(3):
        action, _ = driver.act(frame(seed))
        np.testing.assert_allclose(action, expected.act(frame(seed))[0], rtol=1e-2)


def test_a_chunk_that_is_too_short_is_refused(act: Path) -> None:
    problem = "^hold is 6, expected at most 5: the chunk of this primary$"
    with pytest.raises(ValueError, match=problem):
        Driver.load(act, hold=6)


def test_a_task_that_does_not_show_what_it_sees_is_refused_before_a_drive(act: Path) -> None:
    car = Driving(tracks="willow", traffic=0, seconds=1, action_repeat=3)
    problem = (
        r"^task driving: column 'observation\.image' is missing, expected uint8 \[32, 32, 3\] by"
    )
    with pytest.raises(ValueError, match=problem):
        record_all(car, Naive(), Driver.load(act), [0], seed=(0,), iteration=1, workers=1)


@pytest.mark.parametrize("name", ["observation.state", "action"])
def test_so_is_one_of_other_shapes(act: Path, name: str) -> None:
    features = dict(Pendulum.features)
    driver = Driver.load(act)
    driver.check_task("pendulum", features)
    features[name] = {"dtype": "float32", "shape": (9,), "names": None}
    with pytest.raises(
        ValueError, match=rf"task pendulum: column '{name}' is float32 \[9\], expect"
    ):
        driver.check_task("pendulum", features)


def test_a_safety_policy_watches_it_drive(
    act: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for command in (
        collect("D_0", 2),
        collect("D_safe", 4),
        f"train-safety {act} D_safe D_0 safety {SAFETY}",
        f"rollout {act} safety rollout_1 {DRIVEN} --iteration 1 --queries 9 --frames 20",
        f"rollout-dagger {act} held {DRIVEN} --iteration 1 --beta 0 --frames 20 --hold 3",
        "select rollout_1 new_1",
        "merge D_0 new_1 D_1",
    ):
        assert run(command) == 0, command
    driven = Dataset.open(Path("rollout_1"))
    assert np.isfinite(driven.columns(["primary_action"])["primary_action"]).all()
    assert np.isfinite(driven.column("safe_probability")).all()
    assert driven.lineage.parents[0].own.purpose == "foreign"
    assert "hold" not in driven.lineage.own.arguments
    held = Dataset.open(Path("held"))
    assert held.lineage.own.arguments["hold"] == 3
    anew, _ = propose(load_primary(act), read_all(held, ["observation.image", "observation.state"]))
    same = np.isclose(held.columns(["primary_action"])["primary_action"], anew, rtol=1e-5)[:, 0]
    first = held.column("source.frame") % 3 == 0
    assert same[first].all() and not same[~first].any()

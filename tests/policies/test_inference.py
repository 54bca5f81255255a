"""Driving with networks, and reading them back without LeRobot."""

import subprocess
import sys

import numpy as np
import pytest
import torch

from pipeline.driving.features import CAMERA
from pipeline.driving.network import PrimaryNetwork
from pipeline.policies.inference import Driver, propose
from pipeline.policies.network import SafetyNetwork, to_float

torch.set_num_threads(1)


@pytest.fixture(scope="module")
def primary() -> PrimaryNetwork:
    return PrimaryNetwork(4, generator=torch.Generator().manual_seed(0)).eval()


@pytest.fixture(scope="module")
def safety() -> SafetyNetwork:
    return SafetyNetwork(
        PrimaryNetwork(4).feature_size, 8, generator=torch.Generator().manual_seed(1)
    ).eval()


@pytest.fixture(scope="module")
def images() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (70, 72, 160, 3), dtype=np.uint8)


def test_it_drives_as_the_network_says(primary, images):
    driver = Driver(primary, bfloat16=False)
    with torch.inference_mode():
        outputs = primary(to_float(torch.from_numpy(images[:1])))
    action, signals = driver.act({CAMERA: images[0]})
    assert (action.dtype, action.shape) == (np.float32, (2,))
    assert action[0] == pytest.approx(outputs["steering"].item(), abs=1e-5)
    assert action[1] == float(outputs["brake"][0].softmax(0)[1] > 0.5)
    assert signals == {}  # without a safety policy


def test_bfloat16_is_close(primary, images):
    exact, quick = (Driver(primary, bfloat16=fast) for fast in (False, True))
    for image in images[:5]:
        assert quick.act({CAMERA: image})[0][0] == pytest.approx(
            exact.act({CAMERA: image})[0][0], abs=0.01
        )


def test_the_brake_cut_decides(images):
    never, always = (
        Driver(PrimaryNetwork(4, brake_cut=cut)).act({CAMERA: images[0]})[0] for cut in (1.0, 0.0)
    )
    assert (never[1], always[1]) == (0, 1)


def test_the_safe_probability_is_the_second_of_the_softmax(primary, safety, images):
    driver = Driver(primary, safety, bfloat16=False)
    with torch.inference_mode():
        conv5 = primary.look({CAMERA: torch.from_numpy(images[:1])})
        expected = safety(conv5).softmax(1)[0, 1].item()
    assert driver.act({CAMERA: images[0]})[1] == {"safe_probability": expected}


def test_many_images_at_once_are_as_one_by_one(primary, images):
    driver = Driver(primary, bfloat16=False)
    actions, conv5 = propose(primary, {CAMERA: images}, bfloat16=False)
    assert (actions.dtype, actions.shape) == (np.float32, (70, 2))
    assert (conv5.dtype, conv5.shape) == (np.float16, (70, PrimaryNetwork(4).feature_size))
    for number in (0, 64, 69):
        action, _ = driver.act({CAMERA: images[number]})
        assert actions[number] == pytest.approx(action, abs=1e-5)
        with torch.inference_mode():
            features = primary.look({CAMERA: torch.from_numpy(images[number])[None]})
        assert conv5[number] == pytest.approx(features.flatten().numpy(), rel=2e-3, abs=1e-3)


def test_no_images_give_no_rows(primary):
    actions, conv5 = propose(primary, {CAMERA: np.empty((0, 72, 160, 3), np.uint8)})
    assert (actions.shape, conv5.shape) == ((0, 2), (0, PrimaryNetwork(4).feature_size))


def test_the_drivers_networks_are_its_own(images):
    network = PrimaryNetwork(2, generator=torch.Generator().manual_seed(0))
    driver = Driver(network)
    before, _ = driver.act({CAMERA: images[0]})
    with torch.no_grad():
        network.conv1.weight.zero_()
    assert np.array_equal(before, driver.act({CAMERA: images[0]})[0])
    assert network.training and network.conv1.weight.dtype == torch.float32


def test_a_read_only_image_will_do(primary, images, recwarn):
    image = images[0].copy()
    image.flags.writeable = False
    Driver(primary).act({CAMERA: image})
    assert not recwarn


@pytest.mark.parametrize(
    "image", [np.zeros((160, 72, 3), np.uint8), np.zeros((72, 160, 3), np.float32)]
)
def test_an_image_of_another_kind_is_refused(primary, image):
    with pytest.raises(ValueError, match=r"expected uint8 \(72, 160, 3\)"):
        Driver(primary).act({CAMERA: image})


@pytest.mark.parametrize(
    ("hold", "expected"), [(5, "at most 1: the chunk of this primary"), (0, "at least 1")]
)
def test_what_plans_one_action_at_a_time_has_none_to_hold(primary, hold, expected):
    with pytest.raises(ValueError, match=f"^hold is {hold}, expected {expected}$"):
        Driver(primary, hold=hold)


def test_a_safety_policy_of_another_primary_is_refused(primary):
    with pytest.raises(ValueError, match="safety takes 160 numbers, expected the 320"):
        Driver(primary, SafetyNetwork(160, 8))


def test_driving_does_not_import_lerobot():
    code = "import sys, pipeline.policies.inference; sys.exit('lerobot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0

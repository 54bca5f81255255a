"""What of a policy of LeRobot's a safety policy reads, and which policies are refused."""

from pathlib import Path

import pytest
import torch
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors
from lerobot.policies.tdmpc.configuration_tdmpc import TDMPCConfig
from lerobot.policies.tdmpc.modeling_tdmpc import TDMPCPolicy

from pipeline.policies.lerobot import LeRobotActor
from pipeline.policies.loading import load_primary
from tests.policies.acting import MEAN, STD, frame


def test_a_module_is_read_at_its_input_or_its_output(act: Path) -> None:
    """What ACT's last layer takes, and what it gives, which is the action on its own scale."""
    torch.manual_seed(1)
    seen = {
        "observation.image": torch.randint(0, 256, (2, 32, 32, 3), dtype=torch.uint8),
        "observation.state": torch.randn(2, 3),
    }
    taken, given = (
        load_primary(act, f"model.action_head{end}").look(seen) for end in ("", ":output")
    )
    assert taken.shape == (2, 32 + 1) and given.shape == (2, 1 + 1)
    assert torch.equal(taken[:, -1], given[:, -1])
    torch.testing.assert_close(given[:, 0] * STD + MEAN, given[:, 1], rtol=1e-4, atol=1e-4)
    another = load_primary(act, "model.encoder_robot_state_input_proj")
    assert another.feature_size == 3 + 1


def test_without_a_safety_policy_no_module_need_be_known(act: Path) -> None:
    """It is driven with then, and watched by nobody."""
    policy = ACTPolicy.from_pretrained(act).eval()
    processors = make_pre_post_processors(policy.config, pretrained_path=str(act))
    seen = {n: torch.from_numpy(column)[None] for n, column in frame().items()}
    unread = LeRobotActor(policy, processors, None)
    assert unread.feature_size == 1
    assert torch.equal(unread.look(seen), load_primary(act).look(seen)[:, -1:])


def test_a_policy_that_needs_a_history_is_refused(tmp_path: Path) -> None:
    """TD-MPC, small and untrained: it stacks the frames that it has seen."""
    config = TDMPCConfig(
        input_features={
            "observation.image": PolicyFeature(FeatureType.VISUAL, (3, 84, 84)),
            "observation.state": PolicyFeature(FeatureType.STATE, (3,)),
        },
        output_features={"action": PolicyFeature(FeatureType.ACTION, (1,))},
        image_encoder_hidden_dim=8,
        mlp_dim=8,
        latent_dim=8,
        device="cpu",
        push_to_hub=False,
    )
    TDMPCPolicy(config).save_pretrained(tmp_path)
    ends = {n: torch.ones(1) for n in ("mean", "std", "min", "max")}
    for processor in make_pre_post_processors(config, dataset_stats={"action": ends}):
        processor.save_pretrained(tmp_path)
    with pytest.raises(ValueError, match=r"a tdmpc cannot act on one frame alone .*no history$"):
        load_primary(tmp_path)


@pytest.mark.parametrize(
    ("features_of", "problem"),
    [
        ("model.nothing", "features_of is 'model.nothing', expected a mo"),
        ("model.action_head:middle", "features_of is 'model.action_head:middle', expected a mo"),
        ("model.backbone:output", "where there is .*, expected a tensor"),
    ],
)
def test_a_module_that_it_has_not_is_named(act: Path, features_of: str, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        load_primary(act, features_of)


def test_what_lerobot_does_not_know_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "config.json").write_text('{"type": "nothing"}')
    with pytest.raises(ValueError, match="expected a policy of LeRobot's") as caught:
        load_primary(tmp_path)
    assert "\n" not in str(caught.value)

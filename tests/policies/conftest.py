from pathlib import Path

import pytest
import torch
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors

from tests.policies.acting import MEAN, SHAPES, STD


@pytest.fixture(scope="session")
def act(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Saved as LeRobot saves it, with its processors."""
    path = tmp_path_factory.mktemp("policies") / "act"
    torch.manual_seed(0)
    kinds = (FeatureType.VISUAL, FeatureType.STATE, FeatureType.ACTION)
    features = {
        name: PolicyFeature(kind, shape)
        for (name, shape), kind in zip(SHAPES.items(), kinds, strict=True)
    }
    config = ACTConfig(
        input_features={name: features[name] for name in list(SHAPES)[:2]},
        output_features={"action": features["action"]},
        chunk_size=5,
        n_action_steps=5,
        dim_model=32,
        n_heads=2,
        dim_feedforward=64,
        n_encoder_layers=1,
        n_decoder_layers=1,
        use_vae=False,
        pretrained_backbone_weights=None,
        device="cpu",
        push_to_hub=False,
    )
    statistics = {
        name: {"mean": torch.full(shape, MEAN), "std": torch.full(shape, STD)}
        for name, shape in SHAPES.items()
    }
    statistics["observation.image"] = {n: torch.ones(3, 1, 1) for n in ("mean", "std")}
    ACTPolicy(config).save_pretrained(path)
    for processor in make_pre_post_processors(config, dataset_stats=statistics):
        processor.save_pretrained(path)
    return path

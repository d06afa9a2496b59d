"""rsl_rl's PPO, built from our configuration."""

from __future__ import annotations

import contextlib
import io
import logging

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from rsl_rl.modules import GaussianDistribution

from rl.learning.config import PPOConfig
from rl.learning.equivariant import EquivariantGaussian, EquivariantModel
from rl.task.env import GaitEnv

_log = logging.getLogger(__name__)


def bfloat16_pays() -> bool:
    """Whether this processor multiplies bfloat16 matrices itself (AVX512-BF16 or AMX)."""
    return bool(torch.cpu._is_avx512_bf16_supported() or torch.cpu._is_amx_tile_supported())


def make_ppo(config: PPOConfig, env: GaitEnv) -> PPO:
    """PPO for this environment. Its networks are initialised from torch's global generator."""
    model = {
        "class_name": EquivariantModel if config.equivariant else MLPModel,
        "hidden_dims": list(config.hidden),
        "activation": "elu",
        "obs_normalization": False,
        **({"observation": env.layout} if config.equivariant else {}),
    }
    gaussian = EquivariantGaussian if config.equivariant else GaussianDistribution
    noise = {"class_name": gaussian, "init_std": config.initial_std, "std_type": "log"}
    settings = {
        "num_steps_per_env": config.steps,
        "multi_gpu": None,
        "obs_groups": {
            "actor": ["policy"],
            "critic": ["policy", "privileged"] if config.privileged_critic else ["policy"],
        },
        "actor": {**model, "distribution_cfg": noise},
        "critic": dict(model),
        "algorithm": {
            "class_name": "PPO",
            "num_learning_epochs": config.epochs,
            "num_mini_batches": config.mini_batches,
            "clip_param": config.clip,
            "gamma": config.discount,
            "lam": config.gae_lambda,
            "value_loss_coef": config.value_weight,
            "entropy_coef": config.entropy,
            "learning_rate": config.learning_rate,
            "max_grad_norm": config.max_grad_norm,
            "schedule": "adaptive",
            "desired_kl": config.desired_kl,
            "use_mixed_precision": config.mixed_precision == "on"
            or (config.mixed_precision == "auto" and bfloat16_pays()),
            "rnd_cfg": None,
            "symmetry_cfg": None,
        },
    }
    said = io.StringIO()
    with contextlib.redirect_stdout(said):  # rsl_rl prints
        algorithm = PPO.construct_algorithm(env.get_observations(), env, settings, "cpu")
    _log.debug("%s", said.getvalue())
    return algorithm

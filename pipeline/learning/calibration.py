"""How probable unsafe is: a safety policy that was trained with class weights, or to tell how large a
deviation is, ranks frames; what share of those with a score are unsafe, frames tell that it did not
learn from (Platt 1999).
"""

import numpy as np
import torch
from scipy.optimize import minimize
from torch import nn

from pipeline.policies.network import SafetyNetwork

FLATTEST = 0.01
"""What the logits are stretched by at least: calibration keeps the order of frames."""


def calibrate(
    network: SafetyNetwork, features: np.ndarray, safe: np.ndarray
) -> tuple[float, float]:
    """Stretch and shift a trained network's logits, in place, to the likeliest probabilities: by
    frames float [N, F] that it has not learned from, and whether they are safe, bool [N]. Returned is by
    what the difference of the logits (safe minus unsafe) was multiplied, then what was added. ValueError
    where there are no frames.
    """
    if len(safe) == 0:
        raise ValueError("there are no frames to calibrate with, expected some")
    with torch.inference_mode():
        logits = network(torch.from_numpy(features)).double().numpy()
    apart = logits[:, 1] - logits[:, 0]
    # Platt's labels: never quite 0 or 1, so that a few frames that are all safe leave some doubt
    count = safe.sum()
    labels = np.where(safe, (count + 1) / (count + 2), 1 / (len(safe) - count + 2))

    def loss(factors: np.ndarray) -> float:
        moved = factors[0] * apart + factors[1]
        return float(np.mean(np.logaddexp(0, moved) - labels * moved))

    found = minimize(loss, [1.0, 0.0], bounds=[(FLATTEST, None), (None, None)], method="L-BFGS-B")
    slope, shift = (float(factor) for factor in found.x)
    last = network.layers[-1]
    assert isinstance(last, nn.Linear)
    with torch.no_grad():
        last.weight.mul_(slope)
        last.bias.mul_(slope).add_(torch.tensor([-shift / 2, shift / 2]))
    return slope, shift

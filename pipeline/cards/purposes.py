"""What a dataset is for, in the words of Algorithm 1."""

from pipeline.data.lineage import Made

PROJECT = (
    "Part of safedagger, which runs SafeDAgger (Zhang & Cho 2016, arXiv:1605.06450) on LeRobot "
    "datasets."
)

_MADE = {
    "D_0": "D_0 of Algorithm 1 (line 1): the reference policy drives. What the first primary "
    "policy imitates.",
    "D_safe": "D_safe of Algorithm 1 (line 2): the reference policy drives, from starts that are "
    "spread wide. The safety policies learn from it, no primary policy ever does.",
    "D_held": "Drives of the reference policy like those of D_0, which nothing is trained on: the "
    "threshold tau is judged by them.",
    "supervised": "What supervised learning adds in iteration {iteration}, in the place of lines "
    "6 and 7 of Algorithm 1: the reference policy drives on.",
    "rollout": "D' of Algorithm 1 (line 6), iteration {iteration}: every frame that was driven. "
    "The primary policy drives where its safety policy says safe, else the reference policy, which "
    "is asked for those frames only.",
    "select": "D' of Algorithm 1 after line 7: of a rollout, the frames that the reference was asked "
    "about. Each run of neighbouring frames is an episode.",
    "rollout-dagger": "What DAgger collects in iteration {iteration}, in the place of line 6 of "
    "Algorithm 1: a mixture of reference and primary policy drives, and the reference is asked "
    "about every frame.",
    "sample": "What DAgger keeps, in the place of line 7 of Algorithm 1: a uniform sample of all "
    "that it drove. Each run of neighbouring frames is an episode.",
    "merge": "D_i of Algorithm 1 (line 8): all that was trained on before, and what an iteration "
    "added.",
}


def purpose(made: Made) -> str:
    """What the dataset is for; of a foreign one, only what it is."""
    words = _MADE.get(made.purpose, "Recorded drives, as somebody else has written them.")
    return words.format(iteration=made.arguments.get("iteration"))

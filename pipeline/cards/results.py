"""What was measured of a policy, as its card shows it."""

from pipeline.cards.measured import Measured
from pipeline.driving.tracks import TEST
from pipeline.evaluation.wording import CONDITION_WORDS, amount, count, laps, ratio, share, table
from pipeline.rollout.strategies import Strategy

_STRATEGIES: dict[str, str] = {
    Strategy.NAIVE: "the primary drives",
    Strategy.SAFE: "the reference drives where the safety policy says unsafe",
    Strategy.OPTIMAL: "the reference drives where the deviation is above tau (Eq. 2)",
}


def driving(measured: Measured) -> str:
    """The metrics of Sec. 4.4."""
    if not measured.driving:
        return "Nobody has evaluated it."
    used = dict.fromkeys(strategy for strategy, _ in measured.driving)
    strategies = "; ".join(f"{strategy}: {_STRATEGIES[strategy]}" for strategy in used)
    rows = [
        [
            strategy,
            CONDITION_WORDS[condition],
            f"{of['drives']:,}",
            laps(of["laps"]),
            amount(of["damage_per_lap"]),
            amount(of["steering_mse"]),
            share(of["takeover"]),
            share(of["off_road"]),
        ]
        for (strategy, condition), of in measured.driving.items()
    ]
    header = ["strategy", "condition", "drives", f"laps, at most {measured.most_laps:g}"]
    header += ["damage per lap [m^2/s^2]"]
    header += ["steering MSE", "the reference drives", "drives that left the road"]
    tracks = ", ".join(measured.tracks)
    where = f"the test tracks {tracks}" if TEST.keys() >= set(measured.tracks) else tracks
    return f"On {where}; {strategies}:\n\n{table(header, rows, words=2)}"


def detection(measured: Measured) -> str:
    """How well a safety policy finds what is unsafe; nothing for a primary."""
    found = measured.held_out
    if found is None:
        return ""
    rows = [
        ["AUROC", ratio(found.auroc)],
        ["recall: of the unsafe frames, called unsafe", share(found.recall)],
        ["precision: of those called unsafe, unsafe", share(found.precision)],
        ["unsafe", share(found.share_unsafe)],
        ["called unsafe", share(found.share_predicted_unsafe)],
    ]
    frames = count(measured.held_out_frames)
    return f"\n\nAs a detector, on {frames} held-out frames of D_safe:\n\n{table(['', ''], rows)}"

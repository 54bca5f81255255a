"""Runs are unrolled into the loops of the pipeline: what each iteration reads and writes."""

from pipeline.loops import loops as unrolled
from pipeline.runs import Comparison
from tests.loops import DAGGER, LONG, LOOK, ONE, SHORT, loops

AUDITED = ONE | {"queries": [30, 20, 10], "audit": 0.1, "driven_by": ""}


def test_a_run_is_a_loop_that_begins_with_the_supervised_stage() -> None:
    found = loops(one=ONE)
    assert found["rollouts"] == {
        "one_1": {"iteration": 1, "primary": "0", "safety": "0"}
        | {"asks": {"queries": 30}, "protocol": LONG},
        "one_2": {"iteration": 2, "primary": "one_1", "safety": "one_1"}
        | {"asks": {"queries": 10}, "protocol": LONG},
    }
    assert found["merges"] == {"one_1": {"previous": "0"}, "one_2": {"previous": "one_1"}}
    assert found["steps"] == {
        "one_1": {"previous": "0", "data": "one_1", "samples": 500},
        "one_2": {"previous": "one_1", "data": "one_2", "samples": 500},
    }
    labels = {"tau": 0.1, "horizon": 0, "horizon-mode": "last"}
    assert found["safeties"]["one_2"] == {
        "primary": "one_2",
        "safe": "safe",
        "data": "one_2",
        "labels": labels,
        "strategies": "naive",
    }
    assert list(found["safeties"]) == list(found["evaluated"]) == ["0", "one_1", "one_2"]
    assert found["ledgers"]["one_1"] == {"driven": "rollout_one_1"}
    assert found["pictured"] == ["one_1"]


def test_each_iteration_has_its_own_numbers_where_there_are_several() -> None:
    found = loops(one=ONE | {"samples": [7, 8], "tau": [0.1, 0.2, 0.4]})
    assert [step["samples"] for step in found["steps"].values()] == [7, 8]
    assert [safety["labels"]["tau"] for safety in found["safeties"].values()] == [0.1, 0.2, 0.4]


def test_only_equal_labels_share_the_safety_policy_of_the_supervised_stage() -> None:
    found = loops(one=ONE, same=ONE | {"tau": [0.1, 0.2, 0.2]}, ahead=ONE | {"horizon": 1})
    firsts = [found["rollouts"][f"{name}_1"]["safety"] for name in ("one", "same", "ahead")]
    assert firsts == ["0", "0", "ahead_0"]
    assert found["safeties"]["ahead_0"]["primary"] == "0"


def test_a_run_may_have_better_safety_policies_than_the_papers() -> None:
    better = {"learns": "size", "calibration": 0.2, "cut": 0.7}
    found = loops(one=ONE, better=ONE | better)["safeties"]
    assert found["better_0"]["labels"] == found["0"]["labels"] | better
    assert not better.keys() & found["0"]["labels"].keys()


def test_dagger_and_supervised_learning_need_no_safety_policy_to_drive() -> None:
    supervised = LOOK | {"strategy": "supervised", "episodes": [4], "samples": [9], "tau": [0.1]}
    supervised |= {"protocol": "short"}
    found = loops(one=DAGGER, two=supervised)
    assert found["dagger"]["one_1"] == {
        "iteration": 1,
        "previous": "0",
        "beta": 0,
        "ask": 1,
        "frames": 90,
        "sample": 30,
        "protocol": LONG,
    }
    assert found["supervised"] == {"two_1": {"iteration": 1, "episodes": 4, "protocol": SHORT}}
    assert found["ledgers"]["two_1"] == {"driven": "new_two_1"}
    assert (found["rollouts"], found["pictured"]) == ({}, [])


def test_training_alone_collects_nothing_and_goes_on_with_what_there_is() -> None:
    more = LOOK | {"strategy": "training", "samples": [500, 700], "tau": [0.1], "driven_by": ""}
    found = loops(one=ONE, more=more)
    assert found["steps"]["more_2"] == {"previous": "more_1", "data": "0", "samples": 700}
    for loop in ("merges", "ledgers", "safeties", "evaluated"):
        assert not [step for step in found[loop] if step.startswith("more")], loop


def test_a_safety_policy_that_nobody_asks_is_not_trained() -> None:
    """Of a run that is not evaluated, only those that a rollout needs."""
    found = loops(one=ONE | {"driven_by": ""}, two=DAGGER | {"driven_by": ""})
    assert list(found["safeties"]) == ["0", "one_1"]
    assert found["evaluated"] == {}


def test_the_first_safety_policy_is_there_whoever_asks_for_it() -> None:
    """The runs that share it, or the film alone; it is evaluated as any of them wants."""
    quiet = DAGGER | {"driven_by": ""}
    alone = loops(one=quiet)
    assert (list(alone["safeties"]), alone["evaluated"]) == (["0"], {})
    both = loops(
        one=quiet, two=ONE | {"driven_by": "naive, safe"}, three=ONE | {"driven_by": "naive"}
    )
    assert both["rollouts"]["two_1"]["safety"] == "0"
    assert both["safeties"]["0"]["strategies"] == "naive,safe"
    assert both["evaluated"]["0"] == {"primary": "0", "strategies": "naive,safe"}


def test_audits_of_all_iterations_are_for_the_safety_policy() -> None:
    """Of the last rollout there is none to learn from them."""
    found = loops(one=ONE, two=AUDITED)
    assert found["rollouts"]["two_1"]["asks"] == {"queries": 30, "audit": 0.1}
    assert found["rollouts"]["two_1"]["safety"] == "0"
    assert found["audits"] == {
        "two_1": {"selected": "D_audits_two_1"},
        "two_2": {"selected": "new_audits_two_2"},
    }
    assert found["merges"]["audits_two_2"] == {"previous": "audits_two_1"}
    assert list(found["safeties-audited"]) == ["two_1", "two_2"]
    assert found["safeties-audited"]["two_2"]["safe"] == "safe"
    assert not [step for step in found["safeties"] if step.startswith("two")]


def test_what_is_set_aside_of_d_0_takes_the_place_of_d_safe() -> None:
    """So its loop begins with a primary of its own."""
    found = loops(one=ONE, two=AUDITED | {"set_aside": 0.2})
    assert found["set-aside"] == {"two_0": {"share": 0.2}}
    first = found["safeties"]["two_0"]
    assert (first["primary"], first["safe"], first["data"]) == ("two_0", "safe_two_0", "two_0")
    assert found["safeties-audited"]["two_1"]["safe"] == "safe_two_0"
    rollout = found["rollouts"]["two_1"]
    assert (rollout["primary"], rollout["safety"]) == ("two_0", "two_0")
    assert found["merges"]["two_1"] == {"previous": "two_0"}
    assert found["steps"]["two_1"]["previous"] == "two_0"
    assert found["steps"]["one_1"]["previous"] == "0"


def test_a_run_may_have_a_part_of_d_safe() -> None:
    """So its first safety policy is its own, and watches the primary of all."""
    found = loops(one=ONE, two=ONE | {"d_safe": 0.25}, three=AUDITED | {"d_safe": 0.25})
    assert found["parts-of-D_safe"] == {f"safe_{n}": {"share": 0.25} for n in ("two", "three")}
    safeties = found["safeties"] | found["safeties-audited"]
    for name in ("two", "three"):
        first = safeties[f"{name}_0"]
        assert (first["primary"], first["safe"], first["data"]) == ("0", f"safe_{name}", "0")
        assert safeties[f"{name}_1"]["safe"] == f"safe_{name}"
        rollout = found["rollouts"][f"{name}_1"]
        assert (rollout["primary"], rollout["safety"]) == ("0", f"{name}_0")
        assert found["ledgers"][f"safe_{name}"] == {"driven": f"D_safe_{name}"}
        assert found["steps"][f"{name}_1"]["previous"] == "0"
    assert safeties["0"]["safe"] == safeties["one_2"]["safe"] == "safe"
    assert found["ledgers"]["safe"] == {"driven": "D_safe"}


def test_each_primary_is_counted_on_in_the_end_and_between_where_it_is_told() -> None:
    told = {"runs": {"one": ONE}, "protocols": {"long": LONG}}
    assert unrolled(Comparison.of(told))["relied-on"] == {}
    for there, between in (({"between": "a"}, {"one_1": "a"}), ({}, {})):
        found = unrolled(Comparison.of(told | {"reliability": {"ends": "a,b"} | there}))
        scenarios = {step: told["scenarios"] for step, told in found["relied-on"].items()}
        assert scenarios == {"0": "a,b", "one_2": "a,b"} | between
    aside = {"two": AUDITED | {"set_aside": 0.2}}
    told |= {"runs": told["runs"] | aside, "reliability": {"ends": "a,b", "between": "a"}}
    assert unrolled(Comparison.of(told))["relied-on"]["two_0"] == {"scenarios": "a,b"}


def test_the_first_and_the_last_primaries_drive_in_a_crowd_where_it_is_told() -> None:
    told = {"runs": {"one": ONE}, "protocols": {"long": LONG}}
    assert unrolled(Comparison.of(told))["crowded"] == {}
    there = {"reliability": {"ends": "a,b"}}
    assert unrolled(Comparison.of(told | there))["crowded"] == {}
    there = {"reliability": {"ends": "a,b", "between": "a", "crowded": "b"}}
    found = unrolled(Comparison.of(told | there))["crowded"]
    assert found == {"0": {"scenarios": "b"}, "one_2": {"scenarios": "b"}}


def test_what_stands_beside_the_loops() -> None:
    told = {"runs": {"one": ONE | {"from_scratch": [2]}}, "thresholds": [0.000625, 0.04]}
    told |= {"protocols": {"long": LONG}}
    found = unrolled(Comparison.of(told))
    assert found["from-scratch"] == {"scratch_2": {"data": "one_2", "samples": 500}}
    beside = {n: s for n, s in found["safeties"].items() if n.startswith(("tau", "scratch"))}
    assert list(beside) == ["scratch_2", "tau_000625", "tau_04"]
    assert beside["tau_04"]["labels"]["tau"] == 0.04
    assert beside["scratch_2"]["primary"] == "scratch_2"

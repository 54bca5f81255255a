"""What was measured of safety policies is a table and a picture."""

from pipeline.evaluation.quality import calibration_picture, quality_table
from pipeline.inspection.canvas import png
from pipeline.metric import QUALITY
from tests.evaluation.written import quality


def test_a_row_for_each_situation_and_a_dash_where_nothing_is_known() -> None:
    nothing = dict.fromkeys(QUALITY, None) | {"frames": 0.0}
    rows = [
        {"dataset": "rollout", "situation": "all", **quality(0.9)},
        {"dataset": "rollout", "situation": "nowhere < 2", **nothing},
    ]
    first, last = quality_table(rows).splitlines()[2:]
    assert first.startswith("| rollout | all | 40 | 0.90 | 60.0 % |")
    assert last.startswith("| rollout | nowhere < 2 | 0 | - | - |")


def test_the_picture_has_a_line_for_each_dataset_with_its_error() -> None:
    figure = calibration_picture([{"dataset": "rollout", **quality(0.9)}])
    _, line = figure.axes[0].get_lines()
    assert line.get_label() == "rollout: error 0.10"
    assert list(line.get_xdata()) == [0.1, 0.6]
    assert png(figure)

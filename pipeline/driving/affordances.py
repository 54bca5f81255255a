"""The ten hidden variables of Appendix A, for our car."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.driving.cars import Cars
from pipeline.driving.features import SENSOR_RANGE
from pipeline.driving.tracks import LANE_WIDTH, Track
from pipeline.driving.traffic import along_road, gap_ahead, reaches

FULL_ANGLE = 0.5  # [rad] between car and lane that reads 1.0


def affordances(cars: Cars, track: Track) -> NDArray[np.float32]:
    """[10], in the order of Appendix A.

    Lane to the left, lane to the right, car in front in the left, same and right lane: 0 or 1.
    Distance to each of these cars: [m] bumper to bumper, 0 to SENSOR_RANGE, which it reads where
    there is none. Position in the lane: -1 (right line) to 1 (left line). Angle to the lane: -1 to
    1, where 1 is FULL_ANGLE to the left.
    """
    lane = int(track.lane_of(cars.d[:1])[0])
    lanes = np.array([lane - 1, lane, lane + 1])
    there = reaches(cars.d, track.lane_centres.take(lanes, mode="clip"))
    exists = (lanes >= 0) & (lanes < track.lanes)
    gaps = gap_ahead(along_road(cars, track, 1), there & exists[:, None])
    position = (cars.d[0] - track.lane_centres[lane]) / (0.5 * LANE_WIDTH)
    return np.array(
        [
            lane > 0,
            lane < track.lanes - 1,
            *(gap < SENSOR_RANGE for gap in gaps),
            *gaps,
            min(max(position, -1.0), 1.0),
            min(max(cars.angle(track, 1)[0] / FULL_ANGLE, -1.0), 1.0),
        ],
        dtype=np.float32,
    )

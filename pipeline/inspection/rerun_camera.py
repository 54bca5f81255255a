"""The camera's pictures in Rerun, without loss."""

import cv2
import numpy as np
import rerun as rr
from numpy.typing import NDArray

from pipeline.driving.features import IMAGE_SHAPE
from pipeline.inspection.footage import Footage
from pipeline.inspection.rerun_traces import Trace

AT_ONCE = 64


def _pngs(footage: Footage) -> rr.ComponentColumnList:
    pngs = [_png(image) for image in footage.image]
    return rr.EncodedImage.columns(blob=pngs, media_type=["image/png"] * len(pngs))


def _png(image: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()


def _buffers(footage: Footage) -> rr.ComponentColumnList:
    return rr.Image.columns(buffer=[image.tobytes() for image in footage.image])


_FORMAT = rr.components.ImageFormat(
    width=IMAGE_SHAPE[1], height=IMAGE_SHAPE[0], color_model="RGB", channel_datatype="U8"
)
COMPRESSED = Trace("camera", None, _pngs, AT_ONCE)
"""As PNG."""
RAW = Trace("camera", rr.Image.from_fields(format=_FORMAT), _buffers, AT_ONCE)
"""Twice as large: for a live view, which would wait for each PNG to be read and show none."""

"""What a dataset or a whole run holds, apart from how its files are laid out: hashes.

Reads the files themselves, so that it tells the same of what any commit wrote:

    python -m tests.content HOUSE
"""

import hashlib
import json
import sys
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.policies.computing import processor


def column_hashes(path: Path) -> dict[str, str]:
    """SHA-256 of each column's values in the order of the rows, of images their pixels.

    "episodes" is of the lengths and the tasks of the episodes.
    """
    files = sorted((path / "data").glob("*/*.parquet"))
    table = pa.concat_tables([pq.ParquetFile(file).read() for file in files])
    hashes = {name: _hash(table[name].combine_chunks()) for name in table.column_names}
    episodes = sorted((path / "meta" / "episodes").glob("*/*.parquet"))
    about = pa.concat_tables(
        [pq.ParquetFile(file).read(["length", "tasks"]) for file in episodes]
    ).to_pydict()
    return {**hashes, "episodes": _sha256(json.dumps(about).encode())}


def run_hashes(house: Path) -> dict[str, str]:
    """Of all that a run has made: datasets (see `column_hashes`), weights, and evaluated drives."""
    hashes = {
        f"{path.relative_to(house)}/{column}": value
        for path in sorted((house / "datasets").glob("[!.]*/"))
        for column, value in column_hashes(path).items()
    }
    files = [*(house / "models").glob("*/*.safetensors"), *house.glob("cards/metrics/*/drives_*")]
    return hashes | {str(p.relative_to(house)): _sha256(p.read_bytes()) for p in sorted(files)}


def _hash(values: pa.Array) -> str:
    if pa.types.is_struct(values.type):
        return _sha256(*(_pixels(png) for png in values.field("bytes").to_pylist()))
    if pa.types.is_list(values.type) or pa.types.is_fixed_size_list(values.type):
        values = values.flatten()
    return _sha256(np.ascontiguousarray(values.to_numpy(zero_copy_only=False)).tobytes())


def _pixels(png: bytes) -> bytes:
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR_RGB).tobytes()


def _sha256(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


if __name__ == "__main__":
    print(json.dumps({processor(): run_hashes(Path(sys.argv[1]))}, indent=2, sort_keys=True))

"""What lies in a folder."""

import json
from pathlib import Path
from typing import Any


def tree(root: Path) -> dict[str, bytes]:
    """Every file below `root` with its content."""
    return {
        str(file.relative_to(root)): file.read_bytes() for file in root.rglob("*") if file.is_file()
    }


def strict_json(file: Path) -> dict:
    """The content of a JSON file, which must not hold NaN or Infinity."""

    def refuse(constant: str) -> None:
        raise ValueError(f"{file} has {constant}")

    return json.loads(file.read_text(), parse_constant=refuse)


def rewrite(file: Path, **changes: Any) -> None:
    """Other values in a JSON file."""
    file.write_text(json.dumps(json.loads(file.read_text()) | changes))

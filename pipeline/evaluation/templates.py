"""Markdown from templates: the words are there, the numbers are written as everywhere."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import jinja2

from pipeline.evaluation.wording import count, in_condition, share, written


def template(path: Path, **filters: Callable[..., Any]) -> jinja2.Template:
    """A template, with filters of its own; what it lacks is an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(path.parent),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # it is no HTML
    )
    environment.filters |= {
        "count": count,
        "in_condition": in_condition,
        "of": lambda part, whole: share(part / whole) if whole else "",
        "share": share,
        "written": written,
        **filters,
    }
    return environment.get_template(path.name)

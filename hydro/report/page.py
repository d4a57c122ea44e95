"""From the folder of a run to its page."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from typing import Any

import hydro
from hydro.errors import DeckError
from hydro.output.files import write_text
from hydro.output.folder import RunFolder
from hydro.report.blocks import number
from hydro.report.sections import Content, sections_of


def write_report(path: Path) -> Path:
    """Write report.html into the folder of a run of any kind, from what is there; returns its path.

    DeckError if the folder holds no run, or a summary that cannot be read.
    """
    folder = RunFolder(path)
    content = Content(folder, folder.load_deck(), summary_in(folder))
    write_text(folder.report, page(content))
    return folder.report


def summary_in(folder: RunFolder) -> dict[str, Any]:
    """The summary of a run; empty while there is none."""
    try:
        return json.loads(folder.summary.read_text(encoding="utf-8")) if folder.summary.exists() else {}
    except ValueError as error:
        raise DeckError(f"{folder.summary} cannot be read: {error}", "run folder") from None


def page(content: Content) -> str:
    """The whole page as HTML."""
    from jinja2 import Environment, StrictUndefined

    template = resources.files("hydro.report").joinpath("page.html").read_text(encoding="utf-8")
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    environment.filters["number"] = number
    about = content.deck.about
    return environment.from_string(template).render(
        title=about.title or content.folder.path.resolve().name,
        reference=about.reference,
        notes=about.notes,
        kind=content.deck.kind,
        status=status(content.summary),
        version=hydro.__version__,
        sections=[section for section in sections_of(content) if section.blocks],
    )


def status(summary: dict[str, Any]) -> str:
    """Whether the run has come to its end."""
    if not summary:
        return "under way, or cut short"
    return "completed" if summary["completed"] else "stopped before its end"

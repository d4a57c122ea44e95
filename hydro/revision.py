"""Which revision of the source is running."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path


@cache
def git_revision() -> str | None:
    """The commit of the git checkout that this package lies in, with `-dirty` if files were changed; else None."""
    package = Path(__file__).parent
    try:
        if _git(package, "rev-parse", "--show-prefix") != f"{package.name}/":
            return None  # a checkout of something else, into which the package is installed
        return _git(package, "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    except (OSError, subprocess.SubprocessError):
        return None


def _git(folder: Path, *words: str) -> str:
    done = subprocess.run(["git", *words], cwd=folder, capture_output=True, text=True, check=True, timeout=10.0)
    return done.stdout.strip()

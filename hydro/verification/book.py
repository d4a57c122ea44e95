"""`python -m hydro verify [--full]`: the verification book, as Markdown."""

from __future__ import annotations

from collections.abc import Iterator

from hydro import markdown
from hydro.verification import topics
from hydro.verification.claims import Claim, Findings, Measurement, Table, number

FAILED = 5
PREFACE = """# Verification

Every number here is measured when this page is printed, by `python -m hydro verify{option}`; the tests assert
that those of the quick version hold, but for the ones that fail here too. A bound stays where
it is when a number misses it: the claim is then reported as failing."""


def write(full: bool) -> int:
    """Print the book, chapter by chapter as it is measured; 0 if every claim holds, else 5."""
    print(PREFACE.format(option=" --full" if full else ""), flush=True)
    claims: list[Claim] = []
    for topic, measurements in topics():
        print(f"\n## {topic}\n\n{measurements[0].introduction}", flush=True)
        for measurement in measurements:
            findings = measurement.findings(full)
            claims += findings.claims
            print("\n".join(section(measurement, findings)), flush=True)
    print("\n".join(summary(claims)))
    return 0 if all(claim.passed for claim in claims) else FAILED


def section(measurement: Measurement, findings: Findings) -> Iterator[str]:
    """Lines of one measurement: what is measured, tables, claims."""
    yield f"\n### {measurement.title}\n\n{measurement.explanation}"
    for table in findings.tables:
        yield from table_lines(table)
    if findings.claims:
        rows = [claim_row(claim) for claim in findings.claims]
        yield from table_lines(Table("Claims.", ("claim", "expected", "measured", "bound", ""), rows))


def claim_row(claim: Claim) -> tuple[str, ...]:
    """A claim as a row of a table."""
    verdict = "holds" if claim.passed else "**fails**"
    return claim.statement, claim.expected, number(claim.measured), f"{claim.comparison} {claim.bound:g}", verdict


def table_lines(table: Table) -> Iterator[str]:
    """A table under its caption, as Markdown."""
    yield f"\n{table.caption}\n"
    yield from markdown.table(table.header, [[number(cell) for cell in row] for row in table.rows]).splitlines()


def summary(claims: list[Claim]) -> Iterator[str]:
    """How many claims hold, and which do not."""
    failed = [claim for claim in claims if not claim.passed]
    yield f"\n## Summary\n\n{len(claims) - len(failed)} of {len(claims)} claims hold."
    if failed:
        yield from ("", *(f"- {claim.topic}: {claim}" for claim in failed))

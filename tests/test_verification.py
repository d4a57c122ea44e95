"""Every claim of the quick verification book, one test per measurement; and how claims and the book are written."""

from __future__ import annotations

import pytest

from hydro.errors import StepRejected
from hydro.studies.orders import fitted_order, orders
from hydro.verification import MEASUREMENTS, Claim, Measurement, Table
from hydro.verification.book import claim_row, table_lines

# Claims that miss their bounds; the book reports them as failing. One that comes to hold must leave this list.
KNOWN_FAILURES = {
    "pressure ratio 1e4: overshoot over the jump",
    "dense gas into dilute gas, hllc_lm: overshoot over the jump, any limiter",
    "shock into a cluster, hllc: overshoot over the jump, any limiter",
    "shock into a cluster, hllc_lm: overshoot over the jump, any limiter",
    "vortices at Mach 0.01, hllc_lm: kinetic energy kept",
}


@pytest.mark.parametrize("measurement", MEASUREMENTS, ids=lambda each: f"{each.topic}: {each.title}")
def test_claims_hold(measurement):
    claims = measurement.findings(full=False).claims
    failed = {claim.statement for claim in claims if not claim.passed}
    assert claims
    assert failed == {claim.statement for claim in claims} & KNOWN_FAILURES, "\n".join(map(str, claims))


def test_bounds_are_inclusive_and_words_fail():
    def claim(measured, comparison="<="):
        return Claim("topic", "statement", "expected", measured, 1.0, comparison)

    assert claim(1.0).passed and claim(1.0, ">=").passed
    assert not claim(1.1).passed and not claim(0.9, ">=").passed
    assert not claim("broke down").passed
    assert not claim(float("nan")).passed and not claim(float("nan"), ">=").passed


def test_a_run_that_breaks_down_is_a_failed_claim():
    def breaks(full):
        raise StepRejected

    (claim,) = Measurement("topic", "title", breaks).findings(full=False).claims
    assert not claim.passed
    assert "fails" in claim_row(claim)[-1]


def test_orders_of_a_power_law():
    sizes = [0.1, 0.05, 0.02]
    errors = [3.0 * size**1.7 for size in sizes]
    assert orders(sizes, errors) == pytest.approx([1.7, 1.7])
    assert fitted_order(sizes, errors) == pytest.approx(1.7)


def test_every_measurement_says_what_it_measures():
    assert all(measurement.explanation and measurement.introduction for measurement in MEASUREMENTS)
    assert len({(measurement.topic, measurement.title) for measurement in MEASUREMENTS}) == len(MEASUREMENTS)


def test_tables_are_markdown():
    lines = list(table_lines(Table("Caption.", ("a", "max |b|"), [(1, 0.12345)])))
    assert lines == ["\nCaption.\n", "| a | max \\|b\\| |", "| --- | --- |", "| 1 | 0.123 |"]

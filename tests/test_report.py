"""Pages of runs: what they hold, and how they look in a browser."""

from __future__ import annotations

import json
import re
import shutil
from html.parser import HTMLParser

import numpy as np
import pytest
from conftest import PROBLEMS

from hydro.cli import main
from hydro.movies.video import mp4
from hydro.report.blocks import number

SMALL = {
    "evolution": ("fig4", "mesh.cells=[16,32]", "time.end=3.0", "output.times=[1.0,3.0]"),
    "steady": ("fig3b", "mesh.cells=[16,32]"),
    "branch": ("branches", "mesh.cells=[16,16]", "branch.samples=9", "branch.step=0.5"),
    "stability": ("fig2", "stability.f.count=3"),
}
TITLES = {
    "evolution": ["In brief", "Density", "Movie", "History", "Profiles", "Energy ledger", "Beside a steady state"],
    "steady": ["In brief", "Density", "Modes"],
    "branch": ["In brief", "Branches"],
    "stability": ["In brief", "Marginal curves", "Numbers"],
}
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


class Reader(HTMLParser):
    """Takes a page apart; fails where tags do not match."""

    VOID = frozenset(["meta", "link", "img", "br"])

    def __init__(self, page: str):
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: dict[str, list[str]] = {}
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in self.VOID:
            self.open.append(tag)
            self.text.setdefault(tag, []).append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        for tag in set(self.open):
            self.text[tag][-1] += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A small run of each kind, its report written; the evolution compared and with a movie."""
    root = tmp_path_factory.mktemp("runs")
    for kind, (deck, *overrides) in SMALL.items():
        assert main([str(PROBLEMS / f"{deck}.toml"), *overrides, "--output", str(root / kind), "--quiet"]) == 0
    assert main(["compare", str(root / "evolution"), str(root / "steady"), "--quiet"]) == 0
    movie(root / "evolution" / "movie.mp4")
    for kind in SMALL:
        assert main(["report", str(root / kind), "--quiet"]) == 0
    return root


def movie(path):
    """A second of coloured bars."""
    bars = np.zeros((240, 320, 4), np.uint8)
    for channel, width in enumerate((160, 80, 40)):
        bars[:, np.arange(320) // width % 2 == 0, channel] = 255
    mp4(path, [bars] * 10, 10)


def page_of(folder) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", SMALL)
def test_a_page_holds_all_that_it_shows(runs, kind):
    page = page_of(runs / kind)
    reader = Reader(page)
    assert reader.text["h2"] == [*TITLES[kind], "Scales", "Deck"]
    assert (runs / kind / "deck.toml").read_text() in "".join(reader.text["code"])
    sources = [attributes["src"] for tag in ("img", "video") for attributes in reader.all(tag)]
    assert sources and all(
        source.startswith(("data:image/png;base64,", "data:video/mp4;base64,")) for source in sources
    )
    assert all(attributes["alt"] for attributes in reader.all("img"))
    assert [link["href"] for link in reader.all("link")] == ["data:,"] and not reader.all("script")
    assert not re.search(r"(src|href)=\"(?!data:|#)", page) and "url(" not in page and "@import" not in page
    targets = {attributes.get("id") for _, attributes in reader.tags}
    assert {link["href"].removeprefix("#") for link in reader.all("a")} <= targets


def test_the_page_of_an_evolution_has_its_numbers(runs):
    text = "".join(Reader(page_of(runs / "evolution")).text["main"])
    summary = json.loads((runs / "evolution" / "summary.json").read_text())
    last = summary["snapshots"][-1]
    for value in (last["wall_max"], last["gas_density"], summary["energy_ledger"]["collisions"], summary["mass_drift"]):
        assert number(value) in text
    found = json.loads((runs / "evolution" / "compare" / "compare.json").read_text())
    assert number(found["rates"][0]["growth_rate"]) in text
    assert number(found["checkpoints"][-1]["density"]["L2"]) in text
    assert "wider than the thermal length" in text  # a warning of `check`


def test_what_a_deck_says_of_itself_is_text(run_deck):
    title, notes = '<script>alert("n & T")</script>', "1 < 2 & so on"
    about = (f"about.title='{title}'", f"about.notes='{notes}'")
    folder, code = run_deck("cooling", "mesh.cells=[8,8]", "time.end=0.1", *about)
    assert code == 0 and main(["report", str(folder), "--quiet"]) == 0
    reader = Reader(page_of(folder))
    assert reader.text["h1"] == [title] and notes in reader.text["p"] and not reader.all("script")


def test_a_run_under_way_has_a_page(run_deck):
    folder, _ = run_deck("fig4", *SMALL["evolution"][1:])
    (folder / "summary.json").unlink()
    for picture in folder.glob("pictures/*.png"):
        if not picture.stem.startswith("density_"):
            picture.unlink()
    assert main(["report", str(folder), "--quiet"]) == 0
    reader = Reader(page_of(folder))
    assert "under way" in "".join(reader.text["header"])
    assert reader.text["h2"] == ["In brief", "Density", "History", "Scales", "Deck"]


def test_a_run_whose_first_checkpoint_is_gone_has_a_page(run_deck, runs, tmp_path):
    start = tmp_path / "start.h5"
    shutil.copy(next((runs / "evolution").glob("checkpoints/*.h5")), start)
    words = (*SMALL["evolution"][1:], "initial.kind=checkpoint", f"initial.path={start}")
    folder, code = run_deck("fig4", *words)
    start.unlink()
    assert code == 0 and main(["report", str(folder), "--quiet"]) == 0
    assert "no such checkpoint" in page_of(folder)


def test_a_kind_without_a_page_of_its_own_shows_what_it_has(runs, monkeypatch):
    monkeypatch.delitem(__import__("hydro.report.sections", fromlist=["PARTS"]).PARTS, "branch")
    before = page_of(runs / "branch")
    assert main(["report", str(runs / "branch"), "--quiet"]) == 0
    reader = Reader(page_of(runs / "branch"))
    assert (
        "Results" in reader.text["h2"] and "bifurcation" in "".join(reader.text["main"]) and len(reader.all("img")) == 1
    )
    (runs / "branch" / "report.html").write_text(before, encoding="utf-8")


def test_folders_without_a_run_are_refused(tmp_path, run_deck, capsys):
    assert main(["report", str(tmp_path)]) == 2 and "no folder of a run" in capsys.readouterr().err
    folder, _ = run_deck("cooling", "mesh.cells=[8,8]", "time.end=0.1")
    (folder / "summary.json").write_text("{")
    assert main(["report", str(folder)]) == 2
    message = capsys.readouterr().err
    assert "summary.json" in message and "Traceback" not in message


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0234567, "0.02346"),
        (-1.5e-9, "−1.5\u00a0×\u00a010⁻⁹"),
        (2.5e20, "2.5\u00a0×\u00a010²⁰"),
        (12, "12"),
        (None, "–"),
        (True, "yes"),
        ("text", "text"),
    ],
)
def test_numbers_for_print(value, text):
    assert number(value) == text


# In a browser


@pytest.fixture(scope="module")
def browser():
    """Headless Chromium; where there is none the tests are skipped, and say why."""
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright: pip install 'hydro[test]'")
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.skip(f"no Chromium ({', '.join(BROWSERS)}) on this machine: apt-get install chromium")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("kind", SMALL)
def test_a_page_in_a_browser(runs, browser, kind, width):
    """Nothing is complained about or asked for elsewhere, all is drawn, and nothing sticks out."""
    troubles: list[str] = []
    page = browser.new_page(viewport={"width": width, "height": 844})
    page.on("console", lambda message: troubles.append(message.text))
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.on("requestfailed", lambda request: troubles.append(request.url[:80]))
    page.on("request", lambda sent: troubles.append(sent.url) if not sent.url.startswith(("file:", "data:")) else None)
    page.goto((runs / kind / "report.html").as_uri())
    assert troubles == []
    widths = page.eval_on_selector_all("img", "all => all.map(one => [one.complete, one.naturalWidth])")
    assert widths and all(complete and natural > 0 for complete, natural in widths)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    least = page.evaluate(
        "Math.min(...[...document.querySelectorAll('p, li, td, th, dd, dt, figcaption, a, code')]"
        ".map(one => parseFloat(getComputedStyle(one).fontSize)))"
    )
    assert least >= 12.0
    page.close()


def test_pictures_stay_readable_on_a_phone(runs, browser):
    """Their text, 10 points (13 pixels) at full size, is not shrunk below 60%."""
    page = browser.new_page(viewport={"width": 390, "height": 844})
    for kind in SMALL:
        page.goto((runs / kind / "report.html").as_uri())
        shares = page.eval_on_selector_all("img", "all => all.map(one => one.clientWidth / one.getAttribute('width'))")
        assert min(shares) >= 0.6
    page.close()


def test_the_movie_plays(runs, browser):
    page = browser.new_page()
    page.goto((runs / "evolution" / "report.html").as_uri())
    width = page.evaluate(
        """new Promise((done, fail) => {
            const video = document.querySelector('video');
            video.onerror = () => fail(video.error.message);
            video.ontimeupdate = () => video.currentTime > 0.2 && done(video.videoWidth);
            video.play();
        })"""
    )
    assert width == 320
    page.close()


def test_light_and_dark(runs, browser):
    """Text stands out from the page by a contrast of 7 to 1 in both, 4.5 to 1 where it is soft."""
    for scheme in ("light", "dark"):
        page = browser.new_page(color_scheme=scheme)
        page.goto((runs / "evolution" / "report.html").as_uri())
        paper = luminance(page, "body", "backgroundColor")
        assert (paper > 0.5) == (scheme == "light")
        for selector, least in (("body", 7.0), ("figcaption", 4.5), ("a", 4.5), ("dt", 4.5)):
            shades = sorted((luminance(page, selector, "color"), paper))
            assert (shades[1] + 0.05) / (shades[0] + 0.05) >= least, (scheme, selector)
        page.close()


def luminance(page, selector: str, name: str) -> float:
    """Relative luminance of a colour of the page (Web Content Accessibility Guidelines 2.2)."""
    text = page.eval_on_selector(selector, f"one => getComputedStyle(one).{name}")
    channels = [int(part) / 255.0 for part in re.findall(r"\d+", text)[:3]]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(weight * c for weight, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

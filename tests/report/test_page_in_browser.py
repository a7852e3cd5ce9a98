"""The page as its reader has it: in headless Chromium, by mouse and by finger, on a laptop and on a phone."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.bags import blocks
from wheelset_track_sim.cli import main
from wheelset_track_sim.report import survey

pytestmark = pytest.mark.slow

FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
LAPTOP = {"viewport": {"width": 1366, "height": 768}}
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
SPIKES = [(1.8, 300e3), (4.513, 320e3), (30.0, 555e3), (30.5, 210e3)]
FIGURES = """() => Bokeh.documents.flatMap((document) => [...document.roots()[0].references()])
  .filter((model) => model.type === "Figure").map((figure) => [figure.x_range.start, figure.x_range.end])"""
SHOWN = """() => { for (const document of Bokeh.documents) {
  const shown = document.get_model_by_name("shown")
  if (shown) return Object.fromEntries(Object.entries(shown.data).map(([name, values]) => [name, [...values]])) } }"""
INK = """(plot) => { const canvases = (node) => [...node.querySelectorAll("*")].flatMap((element) =>
    element.tagName === "CANVAS" ? [element] : element.shadowRoot ? canvases(element.shadowRoot) : [])
  return canvases(plot).filter((canvas) => Math.min(canvas.width, canvas.height) > 100).map((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height)
    return data.filter((value, at) => at % 4 === 3 && value > 0).length }) }"""
"""Pixels that are drawn in each canvas of a plot; a legend's patch of colour is a canvas, too, but a small one."""
TOOLTIPS = """() => { const within = (node) => [...node.querySelectorAll("*")].flatMap((element) =>
    [element, ...(element.shadowRoot ? within(element.shadowRoot) : [])])
  return within(document).filter((element) => element.classList.contains("bk-Tooltip") && element.checkVisibility())
    .map((element) => within(element.shadowRoot).filter((row) => row.classList.contains("bk-tooltip-row-label"))
      .map((label) => label.textContent.trim() + label.nextElementSibling.textContent.trim()).join("; ")) }"""
"""Rows of each tooltip that is shown."""
AXIS_COLOUR = """() => [...Bokeh.documents[0].roots()[0].references()]
  .find((model) => model.type === "LinearAxis").major_label_text_color"""


@pytest.fixture(scope="module")
def browser():
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if path is None:
        assert not os.environ.get("CI"), "install the package chromium: .ci/run does"
        pytest.skip("no Chromium here: install the package chromium")
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright drives the browser: make test brings it")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield started
        started.close()


@pytest.fixture(scope="module")
def bags(make_bag, tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")
    return {
        "damaged": make_bag(folder / "damaged.mcap", "damage_wheel_1", 60.0, SPIKES),
        "undamaged": make_bag(folder / "undamaged.mcap", "undamaged", 6.0, ()),
    }


@pytest.fixture(scope="module")
def pages(bags, write_report):
    return {name: write_report(survey(bag), bag.with_suffix(".html")) for name, bag in bags.items()}


@pytest.fixture
def opened(browser):
    """Opens a page, and complains about whatever the page complains about or asks for."""
    contexts, complaints, asked = [], [], []

    def open_page(path: Path, **options):
        contexts.append(browser.new_context(**options))
        page = contexts[-1].new_page()
        page.on("console", lambda said: complaints.append(said.text) if complains(said) else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        page.wait_for_function("document.documentElement.dataset.drawn")
        settle(page)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert complaints == []
    assert all(url.startswith("file://") and url.endswith(".html") for url in asked)
    assert len(asked) == len(contexts)


def complains(said) -> bool:
    # that a picture is read back is what the tests do
    return said.type in ("error", "warning") and "willReadFrequently" not in said.text


def settle(page):
    """Let the page draw what it has to draw."""
    page.wait_for_function("Bokeh.documents.every((document) => document.is_idle)")
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


@pytest.mark.parametrize("name", ["damaged", "undamaged"])
@pytest.mark.parametrize("device", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_all_plots_are_drawn_and_nothing_overflows(opened, pages, name, device):
    page = opened(pages[name], **device)
    width = device["viewport"]["width"]
    assert page.evaluate("document.documentElement.scrollWidth") == width
    wide = "[...document.body.querySelectorAll('*')].filter((e) => e.getBoundingClientRect().right > innerWidth + 1)"
    assert page.evaluate(f"{wide}.map((e) => e.outerHTML.slice(0, 99))") == []
    for plot in ("time-plots", "pressure-plot", "spectrum-plots"):
        box = page.locator(f"#{plot}").bounding_box()
        assert box["width"] > 0.8 * min(width, 640)
        ink = [pixels for pixels in page.locator(f"#{plot}").evaluate(INK) if pixels]
        assert len(ink) == {"time-plots": 4, "pressure-plot": 1, "spectrum-plots": 2}[plot]
        assert min(ink) > 1000
    assert len(page.evaluate(FIGURES)) == 7


def test_no_peak_is_lost_when_all_is_shown(opened, pages):
    shown = opened(pages["damaged"], **LAPTOP).evaluate(SHOWN)
    assert len(shown["time"]) < 5000  # of 60,001 steps
    assert max(shown["value0"]) == 555.0
    assert sorted(value for value in shown["value0"] if value > 200) == [210.0, 300.0, 320.0, 555.0]
    assert min(shown["value0"]) == 0.0
    assert (shown["time"][0], shown["time"][-1]) == (0.0, pytest.approx(2.16, rel=1e-4))


def test_a_drag_zooms_all_time_plots_and_reset_goes_back(opened, pages):
    page = opened(pages["damaged"], **LAPTOP)
    before = page.evaluate(FIGURES)
    ink = page.locator("#time-plots").evaluate(INK)
    page.locator("#time-plots").scroll_into_view_if_needed()
    box = page.locator("#time-plots").bounding_box()
    y = box["y"] + 180
    page.mouse.move(box["x"] + 500, y)
    page.mouse.down()
    page.mouse.move(box["x"] + 600, y, steps=5)
    page.mouse.move(box["x"] + 700, y, steps=5)
    page.mouse.up()
    settle(page)
    after = page.evaluate(FIGURES)
    whole, zoomed = before[0], after[0]
    assert 0 < zoomed[1] - zoomed[0] < 0.3 * (whole[1] - whole[0])
    # all time plots have the new range; the spectra and the pressure keep theirs
    assert [now == zoomed for now in after] == [was == whole for was in before] == [True] * 4 + [False] * 3
    assert [now for now in after if now != zoomed] == [was for was in before if was != whole]
    assert all(now != was for now, was in zip(page.locator("#time-plots").evaluate(INK), ink, strict=True) if was)
    shown = page.evaluate(SHOWN)
    assert zoomed[0] - 1e-3 < min(shown["time"]) <= max(shown["time"]) < zoomed[1] + 1e-3
    page.get_by_role("button", name="Whole run").click()
    settle(page)
    assert page.evaluate(FIGURES) == before


def test_the_wheel_zooms_with_ctrl_and_scrolls_without(opened, pages):
    page = opened(pages["damaged"], **LAPTOP)
    page.locator("#time-plots").scroll_into_view_if_needed()
    box = page.locator("#time-plots").bounding_box()
    before, top = page.evaluate(FIGURES), page.evaluate("scrollY")
    page.mouse.move(box["x"] + 600, box["y"] + 180)
    page.keyboard.down("Control")
    page.mouse.wheel(0, -200)
    page.keyboard.up("Control")
    page.wait_for_function(f"({FIGURES})()[0][0] > {before[0][0]}")
    settle(page)
    zoomed = page.evaluate(FIGURES)
    assert page.evaluate("scrollY") == top
    page.mouse.wheel(0, 200)
    page.wait_for_function(f"scrollY > {top}")
    assert page.evaluate(FIGURES) == zoomed


def test_impacts_are_those_of_the_bag_and_lead_to_their_samples(opened, pages, bags):
    page = opened(pages["damaged"], **LAPTOP)
    rows = [row.split("\t") for row in page.locator("#impacts tbody tr").all_inner_texts()]
    forces = np.concatenate([block.forces for block in blocks(bags["damaged"])])[:, 0]
    steps = np.flatnonzero(forces > 200e3)
    assert [row[2] for row in rows] == [f"{forces[step] / 1e3:.1f} kN" for step in steps]
    assert [row[4] for row in rows] == [f"{step * 1e-3:.3f} m" for step in steps]
    assert [row[0] for row in rows] == [f"{step * 1e-3 / (100 / 3.6):.4f} s" for step in steps]
    assert {row[1] for row in rows} == {"1"}
    page.locator("#impacts tbody button").nth(2).click()
    settle(page)
    shown = page.evaluate(SHOWN)
    time, force = np.array(shown["time"]), np.array(shown["value0"])
    first, last = (round(at / 3.6e-5) for at in (time[0], time[-1]))
    np.testing.assert_allclose(np.unique(time), 3.6e-5 * np.arange(first, last + 1), rtol=1e-6)  # every step
    np.testing.assert_allclose(force[np.unique(time, return_index=True)[1]], forces[first : last + 1] / 1e3, rtol=1e-6)


def test_without_impacts_there_is_no_list(opened, pages):
    page = opened(pages["undamaged"], **PHONE)
    assert page.locator("#impacts").count() == 0
    assert page.get_by_text("There is no impact").is_visible()


def test_fingers_zoom_and_pan_the_plot_and_scroll_the_page(opened, pages):
    page = opened(pages["damaged"], **PHONE)
    page.locator("#time-plots").scroll_into_view_if_needed()
    y = page.locator("#time-plots").bounding_box()["y"] + 180
    fingers = page.context.new_cdp_session(page)

    def touch(kind, *points):
        at = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})
        settle(page)

    whole = page.evaluate(FIGURES)[0]
    touch("touchStart", (180, y), (220, y))
    for way in range(10, 90, 10):
        touch("touchMove", (180 - way, y), (220 + way, y))
    touch("touchEnd")
    zoomed = page.evaluate(FIGURES)[0]
    assert whole[0] < zoomed[0] < zoomed[1] < whole[1]
    touch("touchStart", (200, y))
    for way in range(10, 90, 10):
        touch("touchMove", (200 - way, y))
    touch("touchEnd")
    panned = page.evaluate(FIGURES)[0]
    assert panned[0] > zoomed[0]
    assert panned[1] - panned[0] == pytest.approx(zoomed[1] - zoomed[0])
    top = page.evaluate("scrollY")
    touch("touchStart", (200, y))
    for way in range(10, 90, 10):
        touch("touchMove", (200, y - way))
    touch("touchEnd")
    page.wait_for_function(f"scrollY > {top}")
    assert page.evaluate(FIGURES)[0] == pytest.approx(panned)


def test_dark_and_light(opened, pages):
    seen = {}
    page = opened(pages["undamaged"], **LAPTOP, color_scheme="dark")
    for scheme in ("dark", "light"):
        page.emulate_media(color_scheme=scheme)
        settle(page)
        ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
        seen[scheme] = brightness(ground), brightness(page.evaluate(AXIS_COLOUR))
    assert seen["dark"][0] < 40 < 180 < seen["dark"][1]
    assert seen["light"][0] > 240 > 100 > seen["light"][1]


def brightness(colour: str) -> float:
    if colour.startswith("#"):
        return float(np.mean([int(colour[at : at + 2], 16) for at in (1, 3, 5)]))
    return float(np.mean([float(part) for part in colour[colour.index("(") + 1 : -1].split(",")[:3]]))


def test_the_mouse_reads_the_curves_from_anywhere_over_them(opened, pages):
    page = opened(pages["damaged"], **LAPTOP)
    page.locator("#time-plots").scroll_into_view_if_needed()
    box = page.locator("#time-plots").bounding_box()
    for y, said in ((120, ["wheel 1:100.0 kN", "wheel 2:90.0 kN"]), (400, ["A1:60.0 MPa"]), (570, ["B1:50.0 MPa"])):
        page.mouse.move(box["x"] + 600, box["y"] + y)
        page.wait_for_function(f"({TOOLTIPS})().some((text) => text.includes({said[0]!r}))")
        (shown,) = page.evaluate(TOOLTIPS)
        assert all(text in shown for text in said)
        assert "time:" in shown
        page.mouse.move(5, 5)
        page.wait_for_function(f"({TOOLTIPS})().length === 0")


@pytest.mark.parametrize("width", [1366, 900, 390])
def test_plots_fit_on_paper(opened, pages, width):
    page = opened(pages["damaged"], viewport={"width": width, "height": 844})
    sizes = page.locator(".plot").evaluate_all("(plots) => plots.map((plot) => plot.firstElementChild.offsetWidth)")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 703, "height": 1000})  # A4 with margins of 12 mm
    drawn = "(plots) => plots.map((plot) => plot.firstElementChild.getBoundingClientRect().right)"
    assert page.locator(".plot").evaluate_all(drawn) == pytest.approx([min(690, size) for size in sizes], abs=1)
    assert page.evaluate("document.documentElement.scrollWidth") == 703
    page.emulate_media(media="screen")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.locator(".plot").evaluate_all("(plots) => plots.map((plot) => plot.style.cssText)") == [""] * 3


def test_it_prints_on_paper(opened, pages, tmp_path):
    page = opened(pages["damaged"], **LAPTOP, color_scheme="dark")
    page.evaluate("addEventListener('beforeprint', () => window.printed = Bokeh.documents.length)")
    assert page.pdf(format="A4").startswith(b"%PDF")
    assert page.evaluate("window.printed") == 3
    page.emulate_media(media="print")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert not page.get_by_role("button", name="Whole run").is_visible()
    assert page.locator("#impacts button").first.is_visible()  # the time stays


def test_the_page_of_a_simulated_run(opened, tmp_path, capsys):
    bag, out = tmp_path / "run.mcap", tmp_path / "run.html"
    assert main(["run", "damage_wheel_1", "--duration", "0.5", "--out", str(bag)]) == 0
    assert main(["report", str(bag), "--out", str(out)]) == 0
    page = opened(out, **LAPTOP)
    found = survey(bag).impacts
    assert len(found) == 5
    rows = [row.split("\t") for row in page.locator("#impacts tbody tr").all_inner_texts()]
    assert [row[2] for row in rows] == [f"{impact.peak_force / 1e3:.1f} kN" for impact in found]
    assert [row[6] for row in rows] == [f"{1e3 * impact.contact_loss:.2f} ms" for impact in found]
    assert max(page.evaluate(SHOWN)["value0"]) == pytest.approx(survey(bag).peak.force / 1e3, rel=1e-6)

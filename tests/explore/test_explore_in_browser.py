"""The page in a browser: by keyboard and mouse, wide and narrow, light and dark, two at once, and without a server."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import ROOT
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.scenario import load_scenario

pytest.importorskip("bokeh", reason="the page needs the extra explore")
pytest.importorskip("tornado", reason="the page needs the extra explore")

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
WIDE, NARROW = {"viewport": {"width": 1280, "height": 900}}, {"viewport": {"width": 400, "height": 900}}
DATA = """(name) => { for (const document of Bokeh.documents) {
  const found = document.get_model_by_name(name)
  if (found) return Object.fromEntries(Object.entries(found.data).map(([name, values]) => [name, [...values]])) } }"""
CONTRASTS = """() => {
  const light = (colour) => { const [r, g, b] = colour.match(/[\\d.]+/g).map((part) => { const c = part / 255
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4 }); return 0.2126 * r + 0.7152 * g + 0.0722 * b }
  const ground = (element) => { for (let at = element; at; at = at.parentElement) {
    const colour = getComputedStyle(at).backgroundColor
    if (!colour.endsWith(", 0)") && colour !== "transparent") return colour } }
  const own = (element) => [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())
  return [...document.body.querySelectorAll("*")].filter((e) => (own(e) || e.matches("input, select"))
      && (e.checkVisibility() || e.matches("[role=tooltip]"))).map((e) => {
    const [a, b] = [light(getComputedStyle(e).color), light(ground(e))].sort((x, y) => y - x)
    return [(a + 0.05) / (b + 0.05), e.outerHTML.slice(0, 80)] }) }"""
"""Contrast of each text with what is behind it, as WCAG defines it."""


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


def start(*arguments):
    """A server of its own, and the address that it prints."""
    command = [sys.executable, "-m", "wheelset_track_sim", "explore", *arguments, "--no-browser"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    address = process.stdout.readline().strip()
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[\w-]+/", address)
    return process, address


@pytest.fixture(scope="module")
def program():
    process, address = start("damage_wheel_1")
    yield process, address
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 0
    process.stdout.close()


@pytest.fixture
def opened(browser, program):
    """Opens a page, and complains about whatever the page complains about or asks of others."""
    contexts, complaints, asked = [], [], []

    def open_page(query="", address=program[1], **options):
        contexts.append(browser.new_context(**options))
        page = contexts[-1].new_page()
        page.on("console", lambda said: complaints.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(address + query)
        page.locator("html[data-moment]").wait_for(timeout=120_000)
        settle(page)
        return page

    open_page.complaints = complaints
    yield open_page
    for context in contexts:
        context.close()
    assert complaints == []
    assert all(url.startswith("http://127.0.0.1:") for url in asked)


@pytest.fixture(scope="module")
def wide_page(browser, program):
    """A page for tests that leave it as useful as they found it."""
    context = browser.new_context(**WIDE)
    complaints, page = [], context.new_page()
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(program[1] + "?rough=1")
    page.locator("html[data-moment]").wait_for(timeout=120_000)
    begin = page.evaluate("new URLSearchParams({...controls(), rough: 0}).toString()")
    yield page, begin
    context.close()
    assert complaints == []


@pytest.fixture
def shared(wide_page):
    """That page, at the scenario again."""
    page, begin = wide_page
    answered(page, lambda: page.evaluate("(query) => set(query)", begin))
    return page


def settle(page):
    """Let the page draw what it has to draw."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def answered(page, change):
    """Make a change, and wait for its answer and its contact."""
    before = int(page.locator("html").get_attribute("data-answered"))
    change()
    asked = int(page.evaluate("asked"))
    assert asked > before
    page.locator(f"html[data-answered='{asked}']").wait_for(timeout=120_000)
    page.locator(f"html[data-moment^='{asked}:']").wait_for()
    settle(page)


def peak(page):
    return float(page.locator("#wheel_1-peak").text_content().removesuffix(" kN"))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_is_drawn_readable_and_nothing_overflows(opened, scheme):
    page = opened("?kind=worn_flat", color_scheme=scheme, **WIDE)
    for size in (WIDE, NARROW):
        width = size["viewport"]["width"]
        page.set_viewport_size(size["viewport"])
        settle(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        wide = (
            "[...document.body.querySelectorAll('*')].filter((e) => e.getBoundingClientRect().right > innerWidth + 1)"
        )
        assert page.evaluate(f"{wide}.map((e) => e.outerHTML.slice(0, 99))") == []
        for name in ("forces", "stresses", "bodies", "pressure"):
            assert page.locator(f"#{name}").bounding_box()["width"] > (0.8 if size is NARROW else 0.3) * width
        assert [(ratio, where) for ratio, where in page.evaluate(CONTRASTS) if ratio < 4.5] == []
    axis = page.evaluate("[...roots[0].references()].find((m) => m.type === 'LinearAxis').major_label_text_color")
    assert axis == {"light": "#3c3c42", "dark": "#d6d6da"}[scheme]


def test_axe_finds_nothing(opened):
    library = pytest.importorskip("axe_playwright_python", reason="axe checks pages for people: make test brings it")
    page = opened("?kind=worn_flat&rough=1", **NARROW)
    page.evaluate((Path(library.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
    assert [(each["id"], each["nodes"][0]["html"]) for each in found] == []


def test_keys_change_the_damage_and_the_address(shared):
    page = shared
    assert page.evaluate("Math.max(...shown.arrays.force0)") == pytest.approx(291.16, abs=0.01)
    page.locator("#depth-slider").focus()
    assert page.locator("#depth-tip").is_visible()
    assert page.locator("#depth-tip").text_content() == "Depth of the breakout at its centre. 0 to 5 mm."
    answered(page, lambda: page.keyboard.press("ArrowLeft"))
    assert page.locator("#depth").input_value() == "1.9"
    assert page.evaluate("Math.max(...shown.arrays.force0)") < 290.9
    answered(page, lambda: page.locator("#kind").select_option("flat"))
    assert not page.locator("#depth").is_visible()
    answered(page, lambda: page.locator("#flat").fill("45.5"))
    assert page.locator("#flat-slider").input_value() in ("45", "46")
    assert "kind=flat&on=wheel_1&flat=45.5&" in page.evaluate("location.search")


def test_pins_stay_and_the_link_has_them(opened):
    page = opened(**WIDE)
    page.locator("#pin").click()
    page.locator("html[data-pinned='1']").wait_for()
    answered(page, lambda: page.locator("#depth").fill("0.5"))
    page.locator("#pin").click()
    page.locator("html[data-pinned='2']").wait_for()
    titles = page.locator("#pins li").all_inner_texts()
    assert titles[0].splitlines()[:2] == ["breakout 60 mm 48 mm 2 mm, 100 km/h, 20 t", "291 kN; A1, 81 MPa"]
    first, second = (page.evaluate(DATA, f"force-pin{pin}") for pin in (0, 1))
    assert max(first["value"]) > max(second["value"]) + 30
    again = opened(page.evaluate("location.search"), **NARROW)
    again.locator("html[data-pinned='2']").wait_for()
    assert again.evaluate(DATA, "force-curves") == page.evaluate(DATA, "force-curves")
    assert again.locator("#depth").input_value() == "0.5"
    assert again.evaluate(DATA, "force-pin1") == second
    page.get_by_role("button", name="remove breakout 60 mm 48 mm 2 mm").press("Enter")
    page.locator("html[data-pinned='1']").wait_for()
    settle(page)
    assert page.evaluate(DATA, "force-pin1")["value"] == []
    assert page.evaluate("new URLSearchParams(location.search).getAll('pin').length") == 1
    answered(page, lambda: page.get_by_role("button", name="show breakout 60 mm 48 mm 0.5 mm").click())
    assert page.locator("#depth").input_value() == "0.5"


def test_files_of_the_page(opened, tmp_path):
    page = opened("?depth=1.5", **WIDE)
    peak = page.evaluate("Math.max(...shown.arrays.force0)")
    begins = {".yaml": b"name:", ".mcap": b"\x89MCAP", ".csv": b"", ".html": b"<!DOCTYPE html>"}
    for suffix, begin in begins.items():
        with page.expect_download(timeout=120_000) as download:
            page.locator(f"[data-suffix='{suffix}']").click()
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        assert path.name == f"damage_wheel_1_explored{suffix}"
        assert path.read_bytes().startswith(begin)
    assert read_bag(tmp_path / "damage_wheel_1_explored.mcap").forces[:, 0].max() / 1e3 == pytest.approx(peak, rel=1e-6)
    assert load_scenario(tmp_path / "damage_wheel_1_explored.yaml").irregularities[0].h == 0.0015
    assert "wheel_1 [N]" in (tmp_path / "damage_wheel_1_explored.csv").read_text().splitlines()[0]


def test_every_control_says_what_it_is(shared):
    page = shared
    answered(page, lambda: page.locator("#rough").select_option("1"))
    for control in page.locator("#controls :is(input, select)").all():
        assert (
            control.get_attribute("aria-label") or page.locator(f"label[for='{control.get_attribute('id')}']").count()
        )
        tip = page.locator(f"#{control.get_attribute('aria-describedby')}").text_content()
        assert tip.rstrip().endswith(".")
        if control.get_attribute("type") == "range":
            assert f"{control.get_attribute('min')} to {control.get_attribute('max')}" in tip


def test_the_mouse_and_the_keys_move_the_moment(shared):
    page = shared
    words = page.locator("#pressure-words").text_content()
    assert re.match(r"wheel 1 at 0\.011 m: 291\.2 kN, up to 2\.62 GPa, contact 11 mm long and 25 mm wide", words)
    box = page.locator("#forces").bounding_box()
    at = page.locator("html").get_attribute("data-moment")
    page.mouse.move(box["x"] + 200, box["y"] + 100)
    page.locator(f"html:not([data-moment='{at}'])").wait_for()
    settle(page)
    assert page.locator("#pressure-words").text_content() != words
    bodies = page.evaluate(DATA, "bodies")
    assert min(wheel - rail for wheel, rail in zip(bodies["wheel"], bodies["rail"], strict=True)) == 0
    at = page.locator("html").get_attribute("data-moment")
    page.locator("#moment").focus()
    page.keyboard.press("ArrowRight")
    page.locator(f"html:not([data-moment='{at}'])").wait_for()
    scale = page.evaluate("""() => { const { frame, model } = views.bodies, y = model.y_range
      return (frame.bbox.height / (y.end - y.start)) / (frame.bbox.width / 160) }""")
    assert scale == pytest.approx(5, rel=0.01)  # as the page states


def test_another_wheelset_says_that_it_computes_and_shows_its_nodes(shared):
    page = shared
    page.evaluate("window.said = []")
    page.evaluate(
        "new MutationObserver(() => said.push(by('status').textContent)).observe(by('status'), {childList: true})"
    )
    answered(page, lambda: page.locator("#wheelset").select_option("metro"))
    assert any(words.startswith("computing") for words in page.evaluate("said"))
    assert page.locator("#status").text_content() == ""
    assert page.locator("#nodes").text_content().split() == ["A1", "B1"]


def test_the_verdict_fills_in_the_background(shared):
    page = shared
    answered(page, lambda: page.locator("#kind").select_option("worn_flat"))
    page.locator(f"html[data-scatter='{page.evaluate('answered')}:12']").wait_for(timeout=60_000)
    assert re.match(r"Over 12 places on the bay: peak 1\d\d to \d+ kN", page.locator("#scatter").text_content())
    page.locator(f"html[data-fatigue='{page.evaluate('answered')}:']").wait_for(timeout=120_000)
    assert re.search(r"[5-8]\.\d+ times that without damage, at A1", page.locator("#fatigue").text_content())
    assert page.locator("#verdicts li.alarm").text_content().startswith("wheel 1: length of tread damage 120 mm")
    answered(page, lambda: page.locator("#limits").select_option("fra"))
    assert page.locator("#verdicts li.alarm").count() == 0
    assert "Federal" in page.locator("#sources").text_content()


def test_a_map_leads_to_its_cells_and_a_measurement_lies_beside_the_answer(opened):
    page = opened("?depth=0.5&map=place:depth:stress", **WIDE)
    page.locator("#measured").set_input_files(ROOT / "config" / "measured" / "synthetic_wayside.csv")
    page.locator("html[data-measured]").wait_for()
    assert "gain 1.020, correlation 0.998" in page.locator("#measured-words").text_content()
    force = page.evaluate(DATA, "force-measured")
    assert max(force["value"]) == pytest.approx(230.4, abs=0.1)
    page.locator("html[data-map]").wait_for(timeout=120_000)
    assert [page.locator(f"#map-{side}").input_value() for side in "xy"] == ["place", "depth"]
    page.locator("#map").scroll_into_view_if_needed()
    box = page.evaluate("""() => { const { frame, el } = views.map, box = el.getBoundingClientRect()
      return [box.left + frame.x_scale.compute(325), box.top + frame.y_scale.compute(5)] }""")
    answered(page, lambda: page.mouse.click(*box))
    assert (page.locator("#place").input_value(), page.locator("#depth").input_value()) == ("330", "5")
    assert "map=place:depth:stress" in page.evaluate("location.search")


def test_what_cannot_be_is_one_line_and_the_page_goes_on(shared):
    page = shared
    page.locator("#speed").fill("999")
    page.locator("#status.refused").wait_for()
    assert page.locator("#status").text_content() == (
        "speed = 999 km/h is out of range: give the speed from 18 to 360 km/h"
    )
    answered(page, lambda: page.locator("#speed").fill("90"))
    assert page.locator("#status").text_content() == ""


def memory(process):
    """Resident memory of a process, MB."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) / 1e3


def test_many_quick_changes_and_pages_do_not_make_the_program_grow(opened, program, browser):
    page, other = opened(**NARROW), opened("?kind=flat", **NARROW)

    def drag(page, name, values):
        page.evaluate(
            """([name, values]) => { const slider = by(`${name}-slider`)
              for (const value of values) {
                slider.value = value
                slider.dispatchEvent(new Event("input", {bubbles: true})) } }""",
            [name, values],
        )

    answered(page, lambda: drag(page, "length", [50, 70]))
    answered(other, lambda: drag(other, "flat", [20, 45]))
    before = memory(program[0])
    for turn in range(3):
        answered(page, lambda: drag(page, "length", [*range(20, 120)]))
        answered(other, lambda turn=turn: drag(other, "flat", [20 + turn, 40 + turn]))
    assert (page.locator("#length").input_value(), other.locator("#flat").input_value()) == ("119", "42")
    assert "length=119" in page.evaluate("location.search")
    other.close()
    answered(page, lambda: drag(page, "length", [60]))
    assert peak(page) == 291
    assert memory(program[0]) < before + 60


def test_a_page_without_its_program_says_so(opened):
    process, address = start("undamaged", "--port", "0")
    page = opened(address=address, **WIDE)
    assert page.locator("#kind").input_value() == "none"
    process.kill()
    process.wait()
    process.stdout.close()
    page.get_by_text("the program has ended: start it again").wait_for(timeout=30_000)
    assert all("WebSocket connection" in words for words in opened.complaints)
    opened.complaints.clear()
    page.close()

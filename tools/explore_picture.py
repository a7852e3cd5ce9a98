"""Draw docs/images/explore.png, and print what an answer takes beside a plain simulation of the same passage.

    .venv/bin/python tools/explore_picture.py [FILE.png] [--width 1280] [--dark]

Needs Chromium and playwright.
"""

import argparse
import dataclasses
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from wheelset_track_sim.explore.answers import BEFORE
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.passages import Passages

ROOT = Path(__file__).resolve().parent.parent
FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
PINNED = "pin=kind%3Dworn_flat"
"""A rounded flat beside the breakout: less force, more stress."""
DEPTHS = [0.5 + 0.1 * number for number in range(15)]
"""Of the breakout, mm, each for one answer."""


def main() -> None:
    """Draw and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", nargs="?", type=Path, default=ROOT / "docs" / "images" / "explore.png")
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--dark", action="store_true")
    options = parser.parse_args()
    command = [sys.executable, "-m", "wheelset_track_sim", "explore", "damage_wheel_1", "--no-browser"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as program, sync_playwright() as driver:
        assert program.stdout is not None
        address = program.stdout.readline().strip()
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        scheme = "dark" if options.dark else "light"
        page = browser.new_page(viewport={"width": options.width, "height": 900}, color_scheme=scheme)
        page.goto(f"{address}?{PINNED}")
        for sign in ("pinned", "fatigue"):
            page.locator(f"html[data-{sign}]").wait_for(timeout=300_000)
        for depth in (1.9, 2.0):  # so that the time in the picture is that of a change
            answer(page, depth)
        page.locator(f"html[data-fatigue^='{page.evaluate('asked')}:']").wait_for(timeout=300_000)
        page.evaluate("document.activeElement.blur()")  # its description covers the control below
        page.wait_for_timeout(500)
        page.screenshot(path=options.out, full_page=True)
        shown = [answer(page, depth) for depth in DEPTHS]
        browser.close()
        program.terminate()
    plain = statistics.median(simulated())
    print(f"from change to curve {1e3 * statistics.median(shown):.0f} ms, plain passage {1e3 * plain:.0f} ms: ", end="")
    print(f"{statistics.median(shown) / plain:.1f} times")


def answer(page: Page, depth: float) -> float:
    """Time from a change to the curves in the page, s."""
    page.locator("#depth").fill(f"{depth:.1f}")
    asked = page.evaluate("asked")
    page.locator(f"html[data-answered='{asked}']").wait_for(timeout=60_000)
    return float(page.evaluate("lastAnswer")) / 1e3


def simulated() -> list[float]:
    """Times of the same passages without page and server, s."""
    scenario = load_scenario("damage_wheel_1")
    damage, turn = scenario.irregularities[0], scenario.steps_per_revolution * scenario.step_length
    assert isinstance(damage, Breakout)
    passages = Passages(
        dataclasses.replace(scenario, irregularities=()), before=BEFORE, after=turn - BEFORE - scenario.step_length
    )
    passages.run(())
    times = []
    for depth in DEPTHS:
        began = time.perf_counter()
        passages.run([dataclasses.replace(damage, h=depth / 1e3)])
        times.append(time.perf_counter() - began)
    return times


if __name__ == "__main__":
    main()

"""The server without a browser: who is answered, what a page gets, and what a page that goes leaves behind."""

import asyncio
import gc
import json
import threading
import weakref
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from support.exploring import toy_explorer, unpacked
from support.toy import toy_scenario

pytest.importorskip("bokeh", reason="the page needs the extra explore")
pytest.importorskip("tornado", reason="the page needs the extra explore")

from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.websocket import websocket_connect

from wheelset_track_sim.explore import background, server
from wheelset_track_sim.explore.background import PLACES
from wheelset_track_sim.explore.server import Site, serve
from wheelset_track_sim.explore.view import View
from wheelset_track_sim.scenario import load_scenario

pytestmark = pytest.mark.slow


def served(visit):
    """Run a visitor, ``async visit(site)``, of a site on the toy models."""

    async def run(folder):
        site = Site(toy_scenario())
        site.explorer, site.sockets, site.folder = toy_explorer(), [], folder
        sockets = bind_sockets(0, "127.0.0.1")
        site.port = sockets[0].getsockname()[1]
        listening = HTTPServer(site.application())
        listening.add_sockets(sockets)
        try:
            return await visit(site)
        finally:
            for socket in site.sockets:
                socket.close()
            await closed(site)
            listening.stop()
            await listening.close_all_connections()
            site.worker.close()

    with TemporaryDirectory() as folder:
        return asyncio.run(run(folder))


async def closed(site):
    """Wait until all pages are closed."""
    for _ in range(1000):
        if not site.pages:
            return
        await asyncio.sleep(0.01)
    raise AssertionError("pages stay open")


async def get(site, path, **headers):
    request = HTTPRequest(f"http://127.0.0.1:{site.port}/{path}", headers=headers)
    return await AsyncHTTPClient().fetch(request, raise_error=False)


async def opened(site):
    site.sockets.append(await websocket_connect(f"ws://127.0.0.1:{site.port}/{site.token}/socket"))
    return site.sockets[-1]


async def received(socket, kind, number=None):
    """The next message of a kind."""
    while True:
        message = await asyncio.wait_for(socket.read_message(), 30)
        assert message is not None
        found = unpacked(message)
        if found["kind"] == kind and number in (None, found["number"]):
            return found


def view(number, **values):
    return json.dumps({"number": number, "view": values})


def test_only_the_whole_address_is_answered():
    async def visit(site):
        page = await get(site, f"{site.token}/?kind=flat&flat=45")
        assert page.code == 200
        text = page.body.decode()
        assert '<option value="flat" selected>' in text
        assert 'name="flat" min="5" max="150" step="any" value="45"' in text
        assert "default-src 'none'" in page.headers["Content-Security-Policy"]
        for name in ("bokeh.js", "explore.js", "explore.css"):
            assert (await get(site, f"{site.token}/static/{name}")).code == 200
        for path in (
            "",
            "wrong/",
            "wrong/static/bokeh.js",
            f"{site.token}/static/view.py",
            f"{site.token}/../setup.cfg",
        ):
            refused = await get(site, path)
            assert refused.code == 404
            assert refused.body == b"There is nothing here: open the whole address that the program printed.\n"
        assert (await get(site, f"{site.token}/", Host="evil.example")).code == 403

    served(visit)


def test_an_address_that_cannot_be_used_begins_with_the_scenario_and_says_why():
    async def visit(site):
        text = (await get(site, f"{site.token}/?speed=4000&kind=flat")).body.decode()
        assert "speed = 4000 km/h is out of range" in text
        assert '<option value="none" selected>' in text
        text = (await get(site, f"{site.token}/?wheelset=%3Cscript%3E")).body.decode()
        assert "<script>" not in text
        assert "is not a known wheelset" in text

    served(visit)


def test_a_socket_needs_the_token_and_the_page():
    async def visit(site):
        for url, origin in (("wrong/socket", None), (f"{site.token}/socket", "http://evil.example")):
            request = HTTPRequest(f"ws://127.0.0.1:{site.port}/{url}", headers={"Origin": origin} if origin else {})
            with pytest.raises(Exception, match=r"40[34]"):
                await websocket_connect(request)
        socket = await opened(site)
        await socket.write_message("nonsense")
        assert await asyncio.wait_for(socket.read_message(), 10) is None
        assert socket.close_code == 1003

    served(visit)


def test_a_view_is_answered_with_its_contact_and_moments_follow():
    async def visit(site):
        socket = await opened(site)
        await socket.write_message(view(1, kind="flat", flat="30"))
        answer = await received(socket, "answer")
        assert (answer["number"], answer["bay"]) == (1, 0.6)
        assert answer["arrays"]["force0"].max() > 130
        moment = await received(socket, "moment")
        assert moment["row"] == answer["row"]
        await socket.write_message(json.dumps({"number": 1, "row": 10**9}))
        assert (await received(socket, "moment"))["row"] == len(answer["arrays"]["place"]) - 1
        await socket.write_message(view(2, speed="5000"))
        assert "speed = 5000 km/h is out of range" in (await received(socket, "refused", 2))["words"]
        await socket.write_message(view(3, kind="worn_flat", flat="60", worn="30"))
        assert "worn_length" in (await received(socket, "refused", 3))["words"]

    served(visit)


def test_a_pinned_view_is_answered_beside_the_view():
    async def visit(site):
        socket = await opened(site)
        await socket.write_message(view(1, kind="flat", flat="30"))
        asked = json.dumps({"number": 1, "pin": 2, "view": {"kind": "flat", "flat": "20", "speed": "90"}})
        await socket.write_message(asked)
        pin = await received(socket, "pin")
        assert (pin["pin"], pin["title"]) == (2, "fresh flat 20 mm, 90 km/h, 20 t")
        assert pin["words"].startswith(f"{pin['arrays']['force'].max():.0f} kN; ")
        assert pin["arrays"]["place"].shape == pin["arrays"]["stress"].shape
        await socket.write_message(json.dumps({"number": 5, "row": 3}))  # of no answer that is shown
        await socket.write_message(json.dumps({"number": 1, "row": 3}))  # the view stays what it was
        assert (await received(socket, "moment", 1))["number"] == 1

    served(visit)


def test_the_background_works_for_the_latest_view_and_makes_room(monkeypatch):
    monkeypatch.setattr(background, "DISTANCE", 30.0)
    monkeypatch.setattr(server, "IDLE", 0.0)

    async def visit(site):
        socket = await opened(site)
        for number in range(1, 6):
            await socket.write_message(view(number, kind="flat", flat=str(20 + number)))
            await received(socket, "answer", number)
        done, words = 0, ""
        while done < PLACES or not words:  # in any order
            found = unpacked(await asyncio.wait_for(socket.read_message(), 30))
            assert found["number"] == 5
            if found["kind"] == "scatter":
                done = found["done"]
            elif found["kind"] == "fatigue":
                words = found["words"]
        assert "times that without damage" in words
        assert not site.worker._waiting

    served(visit)


def test_measurements_and_maps_of_a_page():
    async def visit(site):
        socket = await opened(site)
        await socket.write_message(view(1, kind="flat", flat="30"))
        answer = (await received(socket, "answer"))["arrays"]
        rows = [f"{at:.4f},{force:.3f}" for at, force in zip(answer["place"] + 3, answer["force0"], strict=True)]
        text = "\n".join(["position [m],wheel_1 [kN]", *rows])
        await socket.write_message(json.dumps({"number": 1, "name": "mine.csv", "measured": text}))
        assert "gain 1.000" in (await received(socket, "measured"))["words"]
        await socket.write_message(view(2, kind="flat", flat="20"))
        assert (await received(socket, "measured", 2))["words"].startswith("mine.csv, beside the answer")
        await socket.write_message(json.dumps({"number": 2, "name": "bad.csv", "measured": "hello\n"}))
        assert (await received(socket, "refused"))["words"].startswith("bad.csv")
        sides = {"number": 9, "view": {"kind": "flat"}}
        await socket.write_message(json.dumps({**sides, "map": ["flat", "place", "force"]}))
        assert (await received(socket, "map", 9))["of"] == 81
        await socket.write_message(json.dumps({**sides, "number": 10, "map": ["flat", "depth", "force"]}))
        assert "is not a known slider" in (await received(socket, "refused", 10))["words"]
        await socket.write_message(json.dumps({**sides, "map": ["flat"]}))
        assert await asyncio.wait_for(closing(socket), 30) == 1003

    served(visit)


async def closing(socket):
    """Read on until the socket is closed; returns why."""
    while await socket.read_message() is not None:
        pass
    return socket.close_code


def test_files_are_those_of_the_view_and_what_cannot_be_is_one_line():
    async def visit(site):
        found = await get(site, f"{site.token}/download?suffix=.yaml&kind=flat&flat=30&speed=90&place=100")
        assert found.code == 200
        (tmp := Path(site.folder) / "explored.yaml").write_bytes(found.body)
        scenario = load_scenario(tmp)
        expected = site.base.scenario_of(View.read({"kind": "flat", "flat": "30", "speed": "90", "place": "100"}))
        assert (scenario.irregularities, scenario.speed) == (expected.irregularities, expected.speed)
        for query, words in (
            ("suffix=.exe", b"'.exe' is not a known form of file"),
            ("suffix=.csv&speed=1", b"speed = 1 km/h is out of range"),
            ("suffix=.csv&kind=worn_flat&flat=60&worn=30", b"worn_length = 0.03 m is less"),
        ):
            refused = await get(site, f"{site.token}/download?{query}")
            assert (refused.code, words in refused.body) == (400, True)
        assert (await get(site, "wrong/download?suffix=.yaml")).code == 404

    served(visit)


def test_a_failure_of_the_program_is_a_line_on_the_page_and_the_next_view_is_answered(capsys):
    async def visit(site):
        answers, site.explorer.answer = site.explorer.answer, lambda *_: 1 / 0
        socket = await opened(site)
        await socket.write_message(view(1))
        assert "ZeroDivisionError" in (await received(socket, "refused", 1))["words"]
        site.explorer.answer = answers
        await socket.write_message(view(2))
        assert (await received(socket, "answer"))["number"] == 2

    served(visit)
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_of_many_quick_changes_the_last_is_answered_and_two_pages_get_their_own():
    async def visit(site):
        first, second = await opened(site), await opened(site)
        for number in range(1, 301):
            await first.write_message(view(number, kind="flat", flat=str(20 + number / 100)))
            await second.write_message(view(number, kind="none"))
        ours, theirs = await asyncio.gather(received(first, "answer", 300), received(second, "answer", 300))
        assert "flat=23&" in ours["query"]
        assert "kind=none" in theirs["query"]
        assert ours["arrays"]["force0"].max() > theirs["arrays"]["force0"].max() + 10
        assert len(site.worker._waiting) <= 2

    served(visit)


def test_a_closed_page_leaves_nothing():
    async def visit(site):
        sockets = [await opened(site) for _ in range(5)]
        for socket in sockets:
            await socket.write_message(view(1, kind="flat"))
        await received(sockets[0], "answer")
        pages = [weakref.ref(page) for page in site.pages]
        assert len(pages) == 5
        for socket in sockets:
            socket.close()
        await closed(site)
        idle = threading.Event()
        site.worker.submit("end", "end", idle.set, rank=99)
        await asyncio.to_thread(idle.wait, 30)
        del sockets, socket
        return site, pages

    site, pages = served(visit)
    gc.collect()
    assert [page() for page in pages] == [None] * 5
    site.worker._thread.join(10)
    assert not site.worker._thread.is_alive()


def test_a_port_that_is_taken_is_refused_in_one_line():
    taken = bind_sockets(0, "127.0.0.1")
    port = taken[0].getsockname()[1]
    try:
        with pytest.raises(ValueError, match=f"port {port} cannot be used .*: give another one, or none"):
            asyncio.run(serve(toy_scenario(), port))
    finally:
        for socket in taken:
            socket.close()

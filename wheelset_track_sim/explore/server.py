"""The server of the page: for this machine alone, behind a token, with one thread that works for all pages."""

from __future__ import annotations

import asyncio
import json
import secrets
import signal
import socket
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias
from urllib.parse import urlencode

from bokeh.resources import Resources
from tornado.httpserver import HTTPServer
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from ..errors import InputError, WheelsetTrackError
from ..runtime.progress import Progress
from ..scenario import Scenario
from ..twin.measured import Measurement, read_measurement
from .answers import Answer, Explorer
from .background import beside, fatigue, heat_map, scatter
from .downloads import content
from .messages import answer_message, moment_message, packed
from .page import asset, page, style
from .plots import PINS
from .view import Base, View
from .worker import SupersededError, Worker

ADDRESS = "127.0.0.1"
SECURITY = (
    "default-src 'none'; style-src 'self' 'unsafe-inline'; script-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""The browser itself prevents requests to others; ``{host}`` is that of the page."""
LONGEST_MESSAGE = 20_000_000
"""Bytes of a message from a page: a measurement is one."""
LONGEST_NAME = 60
"""Characters of the name of a measurement."""
PING = 20.0
"""Time between signs of life of a page, s: one that is gone without a word is forgotten."""
PROGRESS = 0.2
"""Time between messages of progress, s."""


BACKGROUND = 2
"""Rank of what nobody waits for."""
IDLE = 0.4
"""Time without a change after which work in the background begins, s."""

Slices: TypeAlias = Iterator[Mapping[str, Any] | None]


class Site:
    """What all pages of a server share: the scenario, the worker, the token.

    Only the worker's thread calls the explorer.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.base = Base.of(scenario)
        self.explorer = Explorer(self.base)
        self.worker = Worker()
        self.token = secrets.token_urlsafe(16)
        self.port = 0
        self.pages: set[Page] = set()
        self.downloading = asyncio.Lock()

    @property
    def hosts(self) -> tuple[str, ...]:
        """Hosts of requests that are answered: a name of another machine that leads here is none of them."""
        return f"{ADDRESS}:{self.port}", f"localhost:{self.port}"

    def address(self, query: str = "") -> str:
        """Address of the page."""
        return f"http://{ADDRESS}:{self.port}/{self.token}/" + (f"?{query}" if query else "")

    def application(self) -> Application:
        """Handlers of the requests."""
        library = Resources(mode="inline", components=["bokeh"], log_level="warn").js_raw
        content = {
            "bokeh.js": ("text/javascript", "\n".join(library)),
            "explore.js": ("text/javascript", asset("explore.js")),
            "explore.css": ("text/css", style()),
        }
        shared = {"site": self}
        return Application(
            [
                (r"/([\w-]+)/", Opening, shared),
                (r"/([\w-]+)/static/([\w.]+)", Static, shared | {"content": content}),
                (r"/([\w-]+)/download", Download, shared),
                (r"/([\w-]+)/socket", Page, shared),
            ],
            default_handler_class=Missing,
            default_handler_args=shared,
            websocket_ping_interval=PING,
            websocket_max_message_size=LONGEST_MESSAGE,
            log_function=lambda _: None,
        )


class Guarded(RequestHandler):
    """Refuses requests without the token, and those that come under another name."""

    def initialize(self, site: Site) -> None:
        """Of the site."""
        self.site = site

    def prepare(self) -> None:
        """Check token and host."""
        token = self.request.path.split("/")[1]
        if not secrets.compare_digest(token.encode(), self.site.token.encode()):
            raise HTTPError(404)
        if self.request.host not in self.site.hosts:
            raise HTTPError(403)

    def set_default_headers(self) -> None:
        """Keep everything within the page."""
        self.set_header("Content-Security-Policy", SECURITY.format(host=self.request.host))
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cache-Control", "no-store")
        self.clear_header("Server")

    def write_error(self, status_code: int, **_: Any) -> None:
        """One line."""
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        failed = "The page failed: see the terminal, and report it."
        missing = "There is nothing here: open the whole address that the program printed."
        self.finish(f"{failed if status_code >= 500 else missing}\n")

    def view(self, *further: str) -> View:
        """View of the address, in which names ``further`` are something else; raises InputError."""
        names = [name for name in self.request.query_arguments if name not in further]
        view = View.read({name: self.get_query_argument(name) for name in names}, self.site.base.begin)
        self.site.base.scenario_of(view)
        return view


class Missing(Guarded):
    """Any other address."""

    def get(self) -> None:
        """Nothing."""
        raise HTTPError(404)


class Opening(Guarded):
    """The page."""

    def get(self, *_: str) -> None:
        """The page for the view of the address; for that of the scenario, with the reason, if it cannot be used."""
        pins, mapped, refused = self.get_query_arguments("pin")[:PINS], self.get_query_argument("map", ""), ""
        try:
            view = self.view("pin", "map")
        except InputError as refusal:
            view, refused = self.site.base.begin, f"{refusal}; the page begins with the scenario instead"
        self.finish(page(self.site.base, view, pins, mapped, refused))


class Static(Guarded):
    """Scripts and style: all that the page loads."""

    def initialize(self, site: Site, content: Mapping[str, tuple[str, str]] | None = None) -> None:
        """Of the site, with files by name: type and text."""
        super().initialize(site)
        self.content = content or {}

    def get(self, _: str, name: str) -> None:
        """One file."""
        if name not in self.content:
            raise HTTPError(404)
        kind, text = self.content[name]
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.finish(text)


class Download(Guarded):
    """Files of a view, one after the other."""

    async def get(self, _: str) -> None:
        """A file in the form that the address names by its suffix; one line of text if there is none."""
        try:
            suffix, scenario = self.get_query_argument("suffix"), self.site.base.scenario_of(self.view("suffix"))
            async with self.site.downloading:
                found = await asyncio.to_thread(content, scenario, suffix)
        except WheelsetTrackError as refusal:
            self.set_status(400)
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            self.finish(str(refusal))
            return
        self.set_header("Content-Type", "application/octet-stream")
        self.finish(found)


class Page(WebSocketHandler, Guarded):
    """An open page: takes its requests, and sends what the worker answers."""

    def open(self, *_: str, **__: str) -> None:
        """Begin."""
        self.answer: Answer | None = None
        self.measurement: tuple[str, Measurement] | None = None
        self.number, self.mapped = 0, 0
        self.loop = asyncio.get_running_loop()
        self.set_nodelay(True)
        self.site.pages.add(self)

    def on_close(self) -> None:
        """Forget the page and what waits for it."""
        self.site.pages.discard(self)
        self.site.worker.drop(self)
        self.site.worker.submit(self, "end", self.forget)

    def forget(self) -> None:
        """Let go of the run, in the thread that has used it."""
        self.answer = self.measurement = None

    def on_message(self, message: str | bytes) -> None:
        """Take a request: a view, or a sample of the latest answer."""
        try:
            asked = json.loads(message)
            number = int(asked["number"])
            if "map" in asked or "measured" in asked:
                self.take(number, asked)
                return
            if "row" in asked:
                row = int(asked["row"])
                self.site.worker.submit(self, "moment", lambda: self.show(number, row))
                return
            given = {str(name): str(value) for name, value in dict(asked["view"]).items()}
            pin = int(asked["pin"]) if "pin" in asked else None
        except (ValueError, TypeError, KeyError, RecursionError):
            self.close(1003, "not a request of the page")
            return
        try:
            view = View.read(given, self.site.base.begin)
        except InputError as refusal:
            if pin is None:
                self.site.worker.drop(self, "view")
            self.send(packed({"kind": "refused", "number": number, "words": str(refusal)}))
            return
        if pin is None:
            self.site.worker.submit(self, "view", lambda: self.respond(number, view))
        elif 0 <= pin < PINS:
            self.site.worker.submit(self, f"pin {pin}", lambda: self.pinned(number, view, pin), rank=1)

    def take(self, number: int, asked: Mapping[str, Any]) -> None:
        """Take a request of a map, or a measurement that the page shows from now on; ValueError if it is neither."""
        if "measured" in asked:
            name, text = str(asked["name"])[:LONGEST_NAME], str(asked["measured"])
            self.site.worker.submit(self, "measured", lambda: self.measure(number, name, text))
            return
        x, y, quantity = (str(each) for each in asked["map"])
        self.mapped = number
        with self.refusing(number):
            view = View.read(
                {str(name): str(value) for name, value in dict(asked["view"]).items()}, self.site.base.begin
            )
            slices = heat_map(self.site.explorer, view, x, y, quantity)
            self.site.worker.submit(self, "map", lambda: self.fill(number, slices), BACKGROUND)

    def fill(self, number: int, slices: Slices) -> None:
        """Send cells of a map while no page waits for an answer; in the thread."""
        with self.refusing(number):
            for found in slices:
                if number != self.mapped or self.ws_connection is None:
                    return
                self.post(packed({**(found or {}), "number": number}))
                if self.site.worker.busy(BACKGROUND):
                    break
            else:
                return
            self.site.worker.submit(self, "map", lambda: self.fill(number, slices), BACKGROUND)

    def measure(self, number: int, name: str, text: str) -> None:
        """Read a measurement, none if the text is empty, and show it beside the answer; in the thread."""
        self.measurement = None
        with self.refusing(number), TemporaryDirectory(prefix="explore_") as folder:
            if text:
                path = Path(folder) / "measured.csv"
                path.write_text(text, encoding="utf-8")
                try:
                    self.measurement = name, read_measurement(path)
                except InputError as refusal:
                    raise InputError(str(refusal).replace(str(path), name)) from None
        self.show_measured(number)

    def show_measured(self, number: int) -> None:
        """Send the measurement as it lies beside the latest answer; in the thread."""
        answer, measured = self.answer, self.measurement
        if answer is None or measured is None:
            return
        with self.refusing(number):
            header, arrays = beside(answer, measured[1], measured[0])
            self.post(packed({**header, "number": self.number}, arrays))

    def respond(self, number: int, view: View) -> None:
        """Answer a view; in the worker's thread."""
        with self.refusing(number):
            answer = self.site.explorer.answer(view, self.progress(number))
            self.answer, self.number = answer, number
            self.post(answer_message(number, answer))
        self.show(number, None)
        self.show_measured(number)
        with suppress(RuntimeError):  # the loop has ended
            self.loop.call_soon_threadsafe(self.loop.call_later, IDLE, self.look_further, number)

    def look_further(self, number: int) -> None:
        """Begin the work in the background for an answer, if it is still the latest."""
        answer = self.answer
        if answer is None or number != self.number or self.ws_connection is None:
            return
        explorer = self.site.explorer
        self.go_on(number, "scatter", lambda: scatter(explorer, answer))
        self.go_on(number, "fatigue", lambda: fatigue(explorer, answer, self.unless_busy(number)))

    def go_on(self, number: int, kind: str, make: Callable[[], Slices], slices: Slices | None = None) -> None:
        """Have slices of work done while no page waits for an answer."""
        self.site.worker.submit(self, kind, lambda: self.work(number, kind, make, slices), BACKGROUND)

    def work(self, number: int, kind: str, make: Callable[[], Slices], slices: Slices | None) -> None:
        """Do slices, and send what they find; in the thread."""
        slices = slices or make()
        with self.refusing(number):
            try:
                for found in slices:
                    if number != self.number or self.ws_connection is None:
                        return
                    if found is not None:
                        self.post(packed({**found, "number": number}))
                    if self.site.worker.busy(BACKGROUND):
                        self.go_on(number, kind, make, slices)
                        return
            except SupersededError:
                self.go_on(number, kind, make)

    def unless_busy(self, number: int) -> Progress:
        """Progress of work in the background, which breaks it off when a page waits for an answer."""

        def report(_: str, __: float) -> None:
            if number == self.number and self.site.worker.busy(BACKGROUND):
                raise SupersededError

        return report

    def pinned(self, number: int, view: View, pin: int) -> None:
        """Send the curves of a view that is pinned; in the thread."""
        with self.refusing(number):
            self.post(answer_message(number, self.site.explorer.answer(view), pin))

    def show(self, number: int, row: int | None) -> None:
        """Send the contact at a sample of the latest answer, at that of its largest force if None; in the thread."""
        answer = self.answer
        if answer is None or number != self.number or (row is None and self.site.worker.superseded(self, "view")):
            return
        with self.refusing(number):
            row = answer.peak_row if row is None else min(max(row, 0), len(answer.block) - 1)
            self.post(moment_message(number, row, answer, answer.moment(row)))

    def progress(self, number: int) -> Callable[[str, float], None]:
        """Progress that tells the page, and breaks off what is not wanted any more."""
        told = time.monotonic()

        def report(stage: str, share: float) -> None:
            nonlocal told
            if self.site.worker.superseded(self, "view") or self.ws_connection is None:
                raise SupersededError
            if time.monotonic() - told > PROGRESS:
                told = time.monotonic()
                self.post(packed({"kind": "progress", "number": number, "words": f"{stage}, {share:.0%}"}))

        return report

    def refusing(self, number: int) -> Refusing:
        """Context that sends the page what is wrong, in one line."""
        return Refusing(self, number)

    def post(self, message: bytes) -> None:
        """Send a message from another thread."""
        with suppress(RuntimeError):  # the loop has ended
            self.loop.call_soon_threadsafe(self.send, message)

    def send(self, message: bytes) -> None:
        """Send a message, if the page is still there."""
        if self.ws_connection is None:
            return
        with suppress(WebSocketClosedError):
            sent = self.write_message(message, binary=True)
            sent.add_done_callback(lambda done: done.exception())  # a page that has gone meanwhile


class Refusing:
    """Turns errors of an answer into a line on the page: a page must hear of each, and the worker goes on."""

    def __init__(self, of: Page, number: int) -> None:
        self._page, self._number = of, number

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: Any) -> bool:
        if error is None or isinstance(error, SupersededError):
            return True
        words = str(error)
        if not isinstance(error, WheelsetTrackError):
            traceback.print_exception(kind, error, trace)
            words = f"the answer failed ({error!r}): see the terminal, and report it"
        self._page.post(packed({"kind": "refused", "number": self._number, "words": " ".join(words.split())}))
        return True


async def serve(
    scenario: Scenario, port: int, query: Mapping[str, str] | None = None, opened: Callable[[str], None] | None = None
) -> None:
    """Serve the page of a scenario until the program is told to end.

    Parameters
    ----------
    scenario
        What the page begins with.
    port
        Of 127.0.0.1; 0 chooses one that is free.
    query
        Controls that the first address names.
    opened
        Called with the address when the page can be opened.

    Raises
    ------
    InputError
        For a scenario that cannot be explored, or a port that is not free.
    """
    site = Site(scenario)
    try:
        try:
            listening = socket.create_server((ADDRESS, port))
        except OSError as reason:
            raise InputError(f"port {port} cannot be used ({reason.strerror}): give another one, or none") from None
        listening.setblocking(False)
        site.port = listening.getsockname()[1]
        server = HTTPServer(site.application())
        server.add_socket(listening)
        ended = asyncio.Event()
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, ended.set)
        if opened is not None:
            opened(site.address(urlencode(query or {})))
        await ended.wait()
        server.stop()
        for each in [*site.pages]:
            each.close(1001, "the program ends")
        await server.close_all_connections()
    finally:
        site.worker.close()

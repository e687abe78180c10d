"""A real browser for the tests: headless Chromium, driven by its DevTools protocol over two pipes, without a port."""

import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
ANSWER_TIMEOUT_S = 120

OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--remote-debugging-pipe",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
    "--hide-scrollbars",
)

# Chromium reads commands from descriptor 3 and answers on 4. The pipes are moved aside first: either may have the
# other's number. (A shell could do it, but not every shell knows descriptors of two digits.)
LAUNCH = """
import fcntl, os, sys
aside = [fcntl.fcntl(int(one), fcntl.F_DUPFD, 10) for one in sys.argv[1:3]]
for number, one in enumerate(aside, 3):
    os.dup2(one, number)
os.execv(sys.argv[3], sys.argv[3:])
"""


def find_browser():
    """Return the path of an installed Chromium, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """One page of a headless Chromium; a context manager.

    Attributes
    ----------
    messages : list of str
        What the console said, and every uncaught error.
    requests : list of str
        Addresses of all that was requested.
    """

    def __init__(self, width=1280, height=900):
        self.messages, self.requests = [], []
        self.count, self.size = 0, (width, height)

    def __enter__(self):
        self.resources = ExitStack()
        with ExitStack() as undo:
            undo.callback(self.resources.close)
            self._start()
            undo.pop_all()
        return self

    def __exit__(self, *_):
        # No answer comes to the command that ends it.
        self._send("Browser.close")
        self.resources.close()

    def _start(self):
        profile = self.resources.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
        self.said = Path(profile) / "said"
        to_browser, self.commands = os.pipe()
        self.answers, from_browser = os.pipe()
        with self.said.open("wb") as said:
            self.process = subprocess.Popen(
                [
                    *(sys.executable, "-c", LAUNCH, str(to_browser), str(from_browser)),
                    *(find_browser(), *OPTIONS, f"--user-data-dir={profile}"),
                ],
                pass_fds=(to_browser, from_browser),
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=said,
            )
        # It ends by itself when nobody holds the other ends of its pipes.
        self.resources.callback(self.process.wait, timeout=ANSWER_TIMEOUT_S)
        for mine, its in ((self.commands, to_browser), (self.answers, from_browser)):
            self.resources.callback(os.close, mine)
            os.close(its)
        self.buffer = b""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.resize(*self.size)

    session = None

    def call(self, method, **parameters):
        """Send a command and return its answer; note the events that come in between."""
        self._send(method, **parameters)
        while True:
            answer = self._next()
            if answer.get("id") == self.count:
                assert "error" not in answer, f"{method}: {answer['error']['message']}"
                return answer["result"]

    def _send(self, method, **parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session and not method.startswith(("Target.", "Browser.")):
            message["sessionId"] = self.session
        try:
            os.write(self.commands, json.dumps(message).encode() + b"\0")
        except BrokenPipeError:
            raise AssertionError(self._ended()) from None

    def _ended(self):
        """Say that the browser has ended, and what it said."""
        return f"the browser ended: {self.said.read_text(errors='replace')}"

    def wait_for(self, event):
        """Wait until an event has come."""
        while self._next().get("method") != event:
            pass

    def _next(self):
        while b"\0" not in self.buffer:
            part = os.read(self.answers, 1 << 20)
            assert part, self._ended()
            self.buffer += part
        text, _, self.buffer = self.buffer.partition(b"\0")
        message = json.loads(text)
        self._note(message.get("method"), message.get("params", {}))
        return message

    def _note(self, method, event):
        if method == "Network.requestWillBeSent":
            self.requests.append(event["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.messages.append(event["exceptionDetails"]["text"])
        elif method == "Runtime.consoleAPICalled":
            self.messages.append(" ".join(str(one.get("value")) for one in event["args"]))
        elif method == "Log.entryAdded":
            self.messages.append(event["entry"]["text"])

    def open(self, path):
        """Open a file and wait until it and all in it is loaded."""
        self.call("Page.navigate", url=Path(path).resolve().as_uri())
        self.wait_for("Page.loadEventFired")

    def run(self, expression):
        """Return the value of a JavaScript expression, as JSON has it."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer.get("exceptionDetails")
        return answer["result"].get("value")

    def give(self, name, value):
        """Let the page have a value by a global name."""
        self.run(f"globalThis[{json.dumps(name)}] = {json.dumps(value)}; 0")

    def press(self, key, code=0, text=""):
        """Press and release a key."""
        event = {"key": key, "windowsVirtualKeyCode": code}
        self.call("Input.dispatchKeyEvent", type="keyDown", text=text, **event)
        self.call("Input.dispatchKeyEvent", type="keyUp", **event)

    def resize(self, width, height, scale=1, is_phone=False):
        """Give the page a width and height, in CSS pixels."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=scale,
            mobile=is_phone,
        )

    def prefer(self, scheme):
        """Prefer ``light`` or ``dark`` colours."""
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def screenshot(self, path, whole=False):
        """Save what is seen, or the whole page, as PNG."""
        answer = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        Path(path).write_bytes(base64.b64decode(answer["data"]))

"""Headless Chromium, driven as a person does: by clicks at what is seen, and by typing.

It speaks the DevTools protocol over two pipes, so that no other library and no port is needed.
"""

import base64
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ("--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PLACE = (
    "import fcntl, os, sys; a, b = (fcntl.fcntl(int(n), fcntl.F_DUPFD, 10) for n in sys.argv[1:3]); "
    "os.dup2(a, 3); os.dup2(b, 4); os.execv(sys.argv[3], sys.argv[3:])"
)
"""Starts the browser with its pipes at descriptors 3 and 4, where it looks for them."""
PATIENCE = 60.0
"""Longest wait for something to be seen on a busy machine [s]."""


class Browser:
    """One page of a browser of its own.

    Parameters
    ----------
    folder : an empty folder for its profile
    size : width and height of its window [px]
    """

    def __init__(self, folder: Path, size=(1400, 900), dark=False):
        self.trouble: list[str] = []
        self._number = 0
        ours, theirs = os.pipe(), os.pipe()
        pipes = (ours[0], theirs[1])
        flags = [*FLAGS, "--remote-debugging-pipe", f"--user-data-dir={folder / 'profile'}", "about:blank"]
        self._process = subprocess.Popen(
            [sys.executable, "-c", PLACE, *map(str, pipes), CHROMIUM, *flags],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=pipes,
        )
        for pipe in pipes:
            os.close(pipe)
        self._to, self._from = os.fdopen(ours[1], "wb", 0), os.fdopen(theirs[0], "rb", 0)
        self._rest = b""
        self._session = None
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self._call(f"{domain}.enable")
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self._call("Emulation.setDeviceMetricsOverride", **screen)
        if dark:
            feature = {"name": "prefers-color-scheme", "value": "dark"}
            self._call("Emulation.setEmulatedMedia", features=[feature])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        self._to.close(), self._from.close()

    def open(self, address):
        """Open an address and wait until it is loaded."""
        self._call("Page.navigate", url=address)
        self.wait("location.href !== 'about:blank' && document.readyState === 'complete'")

    def value(self, script):
        """Return the value of JavaScript in the page."""
        reply = self._call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in reply, reply["exceptionDetails"]
        return reply["result"].get("value")

    def wait(self, script):
        """Wait until JavaScript in the page is true, or an element, and return its value."""
        end = time.monotonic() + PATIENCE
        while not (value := self.value(f"(one => one instanceof Node || one)({script})")):
            assert time.monotonic() < end, f"never true: {script}"
            time.sleep(0.1)
        return value

    def click(self, selector):
        """Click the middle of the first element of a selector, once it is seen."""
        chosen = f"document.querySelector({json.dumps(selector)})"
        self.wait(f"{chosen} && !{chosen}.disabled && {chosen}.getClientRects().length > 0")
        x, y = self.value(
            f"{chosen}.scrollIntoView({{block: 'center'}}), (r => [r.x + r.width / 2, r.y + r.height / 2])"
            f"({chosen}.getBoundingClientRect())"
        )
        seen = self.value(f"{chosen}.contains(document.elementFromPoint({x}, {y}))")
        assert seen, f"{selector} is covered"
        for kind in ("mousePressed", "mouseReleased"):
            self._call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def write(self, selector, text):
        """Click into a field, and type a text in the place of what is in it."""
        self.click(selector)
        self.value(f"document.querySelector({json.dumps(selector)}).select()")
        self._call("Input.insertText", text=text)

    def choose(self, selector, value):
        """Choose an entry of a list, whose window a browser without a screen does not open."""
        self.click(selector)
        chosen = f"document.querySelector({json.dumps(selector)})"
        self.value(f"{chosen}.value = {json.dumps(value)}, {chosen}.dispatchEvent(new Event('input'))")

    def press(self, key):
        """Press a key: a letter, or one with a name."""
        code = f"Key{key.upper()}" if len(key) == 1 else key
        for kind in ("keyDown", "keyUp"):
            self._call("Input.dispatchKeyEvent", type=kind, key=key, code=code)

    def picture(self, path):
        """Save what is seen."""
        path.write_bytes(base64.b64decode(self._call("Page.captureScreenshot")["data"]))

    def _call(self, method, **words):
        self._number += 1
        message = {"id": self._number, "method": method, "params": words}
        if self._session is not None:
            message["sessionId"] = self._session
        self._to.write(json.dumps(message).encode() + b"\0")
        while True:
            reply = self._next()
            if reply.get("id") == self._number:
                assert "error" not in reply, (method, reply["error"])
                return reply["result"]
            self._note(reply)

    def _next(self):
        while b"\0" not in self._rest:
            piece = self._from.read(65536)
            assert piece, "the browser has ended"
            self._rest += piece
        line, _, self._rest = self._rest.partition(b"\0")
        return json.loads(line)

    def _note(self, event):
        """Take what the console complains of."""
        if event.get("method") == "Runtime.exceptionThrown":
            self.trouble.append(event["params"]["exceptionDetails"]["exception"].get("description", "?"))
        if event.get("method") == "Log.entryAdded" and event["params"]["entry"]["level"] == "error":
            self.trouble.append(event["params"]["entry"]["text"])

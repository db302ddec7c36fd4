"""A headless Chromium by the WebDriver protocol, with no library beside Python's own."""

from __future__ import annotations

import base64
import contextlib
import json
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
PHONE, DESKTOP = (390, 844), (1340, 900)


class Browser:
    """One window.

    Parameters
    ----------
    address
        Address of its session.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def ask(self, path: str, **data: object) -> object:
        """Send a command of the protocol, and give its answer."""
        request = urllib.request.Request(f"{self.address}/{path}", json.dumps(data).encode(), method="POST")
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise AssertionError(error.read().decode()) from error

    def run(self, script: str, *arguments: object) -> object:
        """Run a script in the page, and give what it returns."""
        return self.ask("execute/sync", script=script, args=list(arguments))

    def protocol(self, command: str, **parameters: object) -> dict:
        """Send a command of Chromium's own protocol."""
        return self.ask("goog/cdp/execute", cmd=command, params=parameters)

    def open(self, page: Path, size: tuple[int, int] = DESKTOP, script: bool = True, **media: str) -> None:
        """Open a file in a window of some size, with the script of the page or without, and wait until it is drawn."""
        self.protocol("Emulation.setScriptExecutionDisabled", value=not script)
        features = [{"name": f"prefers-{name.replace('_', '-')}", "value": value} for name, value in media.items()]
        self.protocol("Emulation.setEmulatedMedia", media="", features=features)
        metrics = {"deviceScaleFactor": 1, "mobile": size == PHONE}
        self.protocol("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], **metrics)
        self.ask("url", url=page.as_uri())
        end = time.monotonic() + 20
        while script and not self.run("return document.body.dataset.ready"):
            assert time.monotonic() < end, "the page is not drawn"
            time.sleep(0.02)

    def click(self, selector: str) -> None:
        """Click on the middle of an element as a mouse does."""
        found = self.ask("element", using="css selector", value=selector)
        self.ask(f"element/{found[ELEMENT]}/click")

    def text(self, selector: str) -> str:
        """Text of an element as it is seen."""
        return str(self.run("return document.querySelector(arguments[0]).innerText", selector))

    def choose(self, selector: str, value: object) -> None:
        """Set a slider or a choice, and tell the page of it."""
        script = "const e = document.querySelector(arguments[0]); e.value = arguments[1]; "
        self.run(
            script + "e.dispatchEvent(new Event(e.tagName === 'INPUT' ? 'input' : 'change'))", selector, str(value)
        )

    def picture(self, path: Path, **options: object) -> Path:
        """Save the whole page as a picture."""
        found = self.protocol("Page.captureScreenshot", captureBeyondViewport=True, **options)
        path.write_bytes(base64.b64decode(found["data"]))
        return path


@contextlib.contextmanager
def browser() -> Iterator[Browser]:
    """Start a browser, and end it; without Chromium the test is left out."""
    program, driver = shutil.which("chromium") or shutil.which("chromium-browser"), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no Chromium with its driver is installed")
    arguments = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
    capabilities = {
        "goog:chromeOptions": {"binary": program, "args": arguments},
        "goog:loggingPrefs": {"browser": "ALL"},
    }
    with subprocess.Popen(
        [driver, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        try:
            port = (
                next(line for line in process.stdout if "started successfully on port" in line).split()[-1].strip(".")
            )
            window = Browser(f"http://127.0.0.1:{port}/session")
            started = Browser(f"http://127.0.0.1:{port}").ask("session", capabilities={"alwaysMatch": capabilities})
            window = Browser(f"http://127.0.0.1:{port}/session/{started['sessionId']}")
            yield window
            urllib.request.urlopen(urllib.request.Request(window.address, method="DELETE"), timeout=30).close()
        finally:
            process.terminate()

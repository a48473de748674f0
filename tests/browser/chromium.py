"""Chromium without a window: the system's, driven by the package playwright."""

import contextlib
import os
import shutil

NAMES = ("chromium", "chromium-browser", "google-chrome")


class MissingBrowserError(Exception):
    """There is no Chromium, or nothing to drive it with."""


@contextlib.contextmanager
def open_browser():
    """Give a browser that pages can be opened in."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        path = None
    if not path:
        raise MissingBrowserError("Chromium and the package playwright are needed: 'make browser-tests' installs them")
    with sync_playwright() as playwright:
        # In containers tests run as root, for whom Chromium has no sandbox.
        arguments = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = playwright.chromium.launch(executable_path=path, args=arguments)
        try:
            yield browser
        finally:
            browser.close()

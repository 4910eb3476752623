"""Picture of the first screen of a comparison's report: ``python docs/screenshot.py PAGE FILE.png``."""

import shutil
import sys
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

WIDTH, HEIGHT = 1180, 860
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def main(page: str, picture: str) -> None:
    """Open a page in the system's browser and write what fits the window.

    Parameters
    ----------
    page : str
        Path of an HTML file.
    picture : str
        Path of the PNG file to write.
    """
    found = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if found is None:
        sys.exit(f"the picture needs a browser: install the package chromium, which brings one of {BROWSERS}")
    if not Path(page).is_file():
        sys.exit(f"{page} does not exist; make it first with drivegate compare A B --output FOLDER")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--headless", "--no-sandbox"])
        opened = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
        opened.goto(Path(page).resolve().as_uri())
        shown = Image.open(BytesIO(opened.screenshot()))
        shown.convert("RGB").quantize(48).save(picture, optimize=True)
        browser.close()


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python docs/screenshot.py PAGE FILE.png")
    main(*sys.argv[1:])

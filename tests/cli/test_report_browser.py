"""The page of info --report in a real browser: no console messages, every picture is shown, nothing overflows."""

import os
import re
import shutil
import subprocess
import tempfile

import cli
import png

CHROMIUM = shutil.which("chromium")
OPTIONS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
           "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
           "--enable-logging=stderr", "--v=0"]

# Added to a copy of the page, to ask the browser what it made of it.
QUESTIONS = """<script>addEventListener("load", () => {
  const images = [...document.images];
  const broken = images.filter(i => !i.complete || !i.naturalWidth || !i.getBoundingClientRect().width).length;
  const empty = [...document.querySelectorAll("svg path, svg text")].filter(e => !e.getBoundingClientRect().width &&
    !e.getBoundingClientRect().height).length;
  console.log(`images ${images.length} broken ${broken} empty ${empty} wide ${document.documentElement.scrollWidth -
    innerWidth} scheme ${getComputedStyle(document.body).backgroundColor}`);
})</script>"""


@cli.needs_png
@cli.unittest.skipUnless(CHROMIUM, "package chromium is not installed")
class Browser(cli.Case):
    def browse(self, name, *options):
        """The page's console messages, and its screenshot."""
        profile = tempfile.mkdtemp(prefix="brick-chromium-")
        self.addCleanup(shutil.rmtree, profile, ignore_errors=True)
        result = subprocess.run([CHROMIUM, *OPTIONS, "--user-data-dir=" + profile, "--screenshot=" + self.path("a.png"),
                                 *options, "file://" + self.path(name)], cwd=self.folder, stdin=subprocess.DEVNULL,
                                capture_output=True, text=True, timeout=120)
        self.assertEqual(result.returncode, 0, result.stderr)
        picture = self.read("a.png")
        os.remove(self.path("a.png"))
        return [line for line in result.stderr.splitlines() if "CONSOLE" in line], png.decode(picture)

    def test_console_is_heard(self):
        """So that the silence below means something."""
        self.write("a.html", b"<!DOCTYPE html><title>a</title><script>nothing()</script>")
        self.assertRegex("".join(self.browse("a.html")[0]), "nothing is not defined")

    def look(self, source):
        self.brick("info", source, "--report", "a.html")
        page = self.read("a.html")
        for size, scheme in [("1280,1200", "light"), ("420,1200", "dark")]:
            options = ["--window-size=" + size, "--blink-settings=preferredColorScheme=" + str("dl".index(scheme[0]))]
            console, picture = self.browse("a.html", *options)
            self.assertEqual(console, [])
            width, _, channels, samples = picture
            colours = {bytes(samples[i:i + 3]) for i in range(0, len(samples), channels * 7)}
            self.assertGreater(len(colours), 100, "pictures, charts and text have many colours")

            self.write("b.html", page + QUESTIONS.encode())
            console, _ = self.browse("b.html", *options)
            self.assertEqual(len(console), 1, console)
            images, broken, empty, wide, red = map(int, re.search(
                r"images (\d+) broken (\d+) empty (\d+) wide (-?\d+) scheme rgb\((\d+)", console[0]).groups())
            self.assertEqual((images, broken, empty), (9, 0, 0))
            self.assertLessEqual(wide, 0, "no sideways scrolling at %s" % size)
            self.assertEqual(red > 128, scheme == "light")

    def test_phantom(self):
        self.brick("synth", "ct", "--size", "160x130x100", "-o", "a.brick", "--quiet")
        self.look("a.brick")

    @cli.needs_ct
    def test_real_ct(self):
        self.look(self.ct())


cli.main()

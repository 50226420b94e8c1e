"""The progress line: on a terminal only, one line that fits, and gone in the end."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios

import cli


class Progress(cli.Case):
    def on_terminal(self, columns, *args):
        """What a terminal of that width is sent."""
        here, there = pty.openpty()
        fcntl.ioctl(there, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        process = subprocess.Popen([cli.BRICK, *args], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=there)
        os.close(there)
        said = b""
        while True:
            try:
                part = os.read(here, 65536)
            except OSError:  # the other end is closed
                break
            if not part:
                break
            said += part
        os.close(here)
        self.assertEqual(process.wait(60), 0, said)
        return said.decode()

    def test_line(self):
        synth = ["synth", "ct", "--size", "256x256x200", "-o", "a.brick", "--threads", "1"]
        for columns in [200, 80, 52]:
            said = self.on_terminal(columns, *synth)
            *frames, last = said.split("\r\033[K")[0].split("\r")[1:]
            for frame in [*frames, last]:
                self.assertRegex(frame, r"^synth \[#*\.*\] +\d+%( +\d+\.\d MB/s( +\d+:\d\d left)?)?(, [a-z]+ limits)?\x1b\[K$")
                # What limits is told where there is room.
                self.assertEqual("limits" in frame, columns >= 80)
                self.assertLess(len(frame.replace("\x1b[K", "")), columns)
            bar = re.search(r"\[([#.]*)\]", last).group(1)
            self.assertEqual(len(bar), {200: 30, 80: 80 - len("synth") - 37 - 19, 52: 10}[columns])
            if columns >= 80:
                self.assertIn("finish limits", last)  # tables, the last sync
            # The line is erased; the summary stays.
            self.assertRegex(said.split("\r\033[K")[-1], r"^a\.brick: .* bricks .*\r\n$")

    def test_silence(self):
        self.assertEqual(self.on_terminal(80, "synth", "ct", "--size", "64x64x64", "-o", "a.brick", "--quiet"), "")
        piped = self.run_brick("synth", "ct", "--size", "64x64x64", "-o", "b.brick")
        self.assertEqual(len(piped.stderr.splitlines()), 1)
        self.assertNotIn("\r", piped.stderr)
        self.assertEqual(self.run_brick("info", "a.brick", "--report", "a.html").stderr if cli.HAS_PNG else "", "")


cli.main()

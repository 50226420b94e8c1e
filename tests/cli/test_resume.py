"""Conversions that are killed at any instant go on with --resume, keep what was done, and end with the same bytes."""

import gzip
import os
import random
import signal
import subprocess
import time

import cli

SIZE = "192x192x128"
RAW = ["ct.raw", "--size", SIZE, "--type", "u16"]
SLOW = ["--brick", "16", "--codec", "zstd", "--codec-level", "5"]
TILED = ["--brick", "16", "--memory", "32M"]


class Resume(cli.Case):
    def setUp(self):
        super().setUp()
        self.brick("synth", "ct", "--size", SIZE, "-o", "ct.raw", "--quiet")

    def start(self, *args):
        return subprocess.Popen([cli.BRICK, *args], cwd=self.folder, stdin=subprocess.DEVNULL,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def reap(self, process):
        """Nothing is said by what is killed, nor by what is quiet."""
        self.assertEqual(process.stderr.read(), b"")
        process.stderr.close()
        return process.wait(60)

    def kill_after(self, seconds, *args):
        process = self.start(*args)
        time.sleep(seconds)
        process.send_signal(signal.SIGKILL)
        return self.reap(process)

    def kill_at(self, bytes_written, *args):
        """Kill it when so much is in the unfinished file."""
        process = self.start(*args)
        while process.poll() is None:
            try:
                if os.path.getsize(self.path("a.brick.part")) >= bytes_written:
                    break
            except FileNotFoundError:
                pass
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
        return self.reap(process)

    def nothing_looks_complete(self):
        for name in ["a.brick", "a.brick.part"]:
            if os.path.exists(self.path(name)) and self.run_brick("info", name).returncode == 0:
                self.brick("verify", name)  # then it is complete: killed between the last sync and the end
        self.assertEqual([n for n in os.listdir(self.folder) if "spool" in n], [])

    def killed_and_resumed(self, times, *args, seed):
        rng = random.Random(seed)
        self.brick(*args, "-o", "good.brick", "--quiet")
        good = self.read("good.brick")
        begin = time.monotonic()
        self.brick(*args, "-o", "a.brick", "--quiet")
        seconds = time.monotonic() - begin
        kept = 0
        for turn in range(times):
            if os.path.exists(self.path("a.brick")):
                os.remove(self.path("a.brick"))
            options = [*args, "-o", "a.brick", "--quiet"]
            limit = seconds
            while self.kill_after(rng.uniform(0, limit), *options) != -signal.SIGKILL:
                os.remove(self.path("a.brick"))  # it was faster
                limit *= 0.9
            self.nothing_looks_complete()
            options += ["--resume", "--threads", str(1 + turn % 2)]
            if turn % 3 == 0:
                self.kill_after(rng.uniform(0, seconds), *options)
                self.nothing_looks_complete()
            report = self.json(*options)
            kept += report["bricks_kept"] > 0
            self.assertEqual(self.read("a.brick"), good, "turn %d" % turn)
            self.assertEqual(sorted(os.listdir(self.folder)), self.files, "turn %d" % turn)
        self.assertGreater(kept, times / 5)

    def test_one_thread(self):
        self.files = ["a.brick", "ct.raw", "good.brick"]
        self.killed_and_resumed(12, "convert", *RAW, *SLOW, "--threads", "1", seed=1)

    def test_two_threads(self):
        self.files = ["a.brick", "ct.raw", "good.brick"]
        self.killed_and_resumed(12, "convert", *RAW, *SLOW, "--threads", "2", seed=2)

    def test_tiles(self):
        self.files = ["a.brick", "wide.raw", "good.brick"]
        os.remove(self.path("ct.raw"))
        self.brick("synth", "ct", "--size", "1024x768x48", "-o", "wide.raw", "--quiet")
        self.files.sort()
        options = ["convert", "wide.raw", "--size", "1024x768x48", "--type", "u16", *TILED, "--threads", "2"]
        report = self.json(*options, "-o", "tiled.brick", "--quiet")
        self.assertGreater(report["source_bytes_read"], report["input_bytes"])  # tiles read their borders twice
        os.remove(self.path("tiled.brick"))
        self.killed_and_resumed(12, *options, seed=3)

    @cli.needs_zlib
    def test_gzip(self):
        """A source that can only be read from front to back."""
        header = "NRRD0004\ntype: uint16\ndimension: 3\nsizes: %s\nendian: little\nencoding: gzip\n\n"
        self.write("ct.nrrd", header.replace("%s", SIZE.replace("x", " ")).encode() +
                   gzip.compress(self.read("ct.raw"), 1))
        os.remove(self.path("ct.raw"))
        self.files = ["a.brick", "ct.nrrd", "good.brick"]
        self.killed_and_resumed(8, "convert", "ct.nrrd", *SLOW, "--threads", "2", seed=4)

    def test_synth(self):
        os.remove(self.path("ct.raw"))
        self.files = ["a.brick", "good.brick"]
        self.killed_and_resumed(6, "synth", "ct", "--size", SIZE, *SLOW, seed=5)

    def test_little_is_left_to_do(self):
        """Checkpoints every four rows of bricks, of which there are 32: a tenth is left, and what came after the last one."""
        size = "160x160x512"
        self.brick("synth", "ct", "--size", size, "-o", "ct.raw", "--quiet")
        for codec in [["lz4"], ["none"], ["zstd"]] + [["zfp", "--tolerance", "4"]] * (os.environ["BRICK_ZFP"] == "1"):
            with self.subTest(codec=codec[0]):
                options = ["convert", "ct.raw", "--size", size, "--type", "u16", "--brick", "16", "--threads", "1",
                           "-o", "a.brick", "--quiet", "--codec", *codec]
                whole = self.json(*options)
                good = self.read("a.brick")
                level0 = self.json("info", "a.brick")["levels"][0]
                os.remove(self.path("a.brick"))
                self.assertEqual(self.kill_at(0.9 * level0["payload_bytes"], *options), -signal.SIGKILL)
                report = self.json(*options, "--resume", "--memory", "100M", "--threads", "2")
                self.assertEqual(self.read("a.brick"), good)
                # A tenth is missing, what the last MiB of payload had, and the coarser bricks above.
                self.assertGreater(report["bricks_kept"], 0.75 * report["bricks"])
                self.assertLess(report["bricks_decoded"], 0.2 * report["bricks"])
                self.assertLess(report["source_bytes_read"], 0.4 * whole["source_bytes_read"])
                self.assertEqual(whole["bricks_kept"], 0)
                self.assertEqual(whole["bricks_decoded"], 0)
                self.assertEqual(whole["source_bytes_read"], whole["input_bytes"])

    def test_changes_are_refused(self):
        options = ["convert", *RAW, *SLOW, "--threads", "1", "-o", "a.brick", "--quiet"]
        self.assertEqual(self.kill_at(1 << 20, *options), -signal.SIGKILL)
        for more in [["--codec", "lz4"], ["--brick", "64"], ["--downsample", "nearest"], ["--spacing", "1,1,2"],
                     ["--endian", "big"]]:
            self.fails(1, r"a\.brick\.part: was begun with '.*', but now it is '.*' *: not resumed", *options, "--resume",
                       *more)
        os.utime(self.path("ct.raw"), (1, 1))
        said = self.fails(1, "a.brick.part: was begun with 'source: .* of 2.*', but now it is 'source: .* of 1970-01-01",
                          *options, "--resume")
        self.assertIn("without --resume", said)
        self.brick(*options)
        self.assertEqual(sorted(os.listdir(self.folder)), ["a.brick", "ct.raw"])
        self.brick("verify", "a.brick")

    def test_nothing_to_resume(self):
        report = self.json("convert", *RAW, "-o", "a.brick", "--quiet", "--resume")
        self.assertEqual(report["bricks_kept"], 0)
        self.assertEqual(sorted(os.listdir(self.folder)), ["a.brick", "ct.raw"])

    def test_interrupt(self):
        """As ^C on a terminal."""
        options = ["convert", *RAW, *SLOW, "--threads", "1", "-o", "a.brick", "--quiet"]
        process = self.start(*options)
        while not os.path.exists(self.path("a.brick.part")) or os.path.getsize(self.path("a.brick.part")) < 1 << 20:
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
        self.assertEqual(self.reap(process), -signal.SIGINT)
        self.assertGreater(self.json(*options, "--resume")["bricks_kept"], 0)

    def test_one_at_a_time(self):
        options = ["convert", *RAW, *SLOW, "--threads", "1", "-o", "a.brick", "--quiet"]
        first = self.start(*options)
        while not os.path.exists(self.path("a.brick.part.journal")):
            time.sleep(0.001)
        first.send_signal(signal.SIGSTOP)
        for more in [[], ["--resume"]]:
            self.fails(1, "another process is writing it", *options, *more)
        first.send_signal(signal.SIGCONT)
        self.assertEqual(self.reap(first), 0)
        self.brick("verify", "a.brick")


cli.main()

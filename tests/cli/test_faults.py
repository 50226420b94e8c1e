"""Disks that fail while a picture is being made: one line that names the brick, exit code 1, no picture. A small library
in front of the program's reads (fault.c) lets one of them fail."""

import os
import shutil
import subprocess
import tempfile
from unittest import mock

import cli

METHODS = [["--method", "exact", "--mode", "dvr", "--tf", "gray"], ["--method", "isotrace", "--mode", "iso", "--iso", "100"]]
if cli.HAS_EGL or cli.HAS_OSMESA:
    METHODS += [["--method", "raycast", "--mode", "dvr", "--tf", "gray", "--gpu-cache", "300K"],
                ["--method", "raycast", "--mode", "iso", "--iso", "100"]]


@cli.needs_exr
class Faults(cli.Case):
    @classmethod
    def setUpClass(cls):
        cls.tools = tempfile.mkdtemp(prefix="brick-fault-")
        cls.addClassCleanup(shutil.rmtree, cls.tools)
        compiler = shutil.which("cc")
        if not compiler:
            raise cli.unittest.SkipTest("no C compiler")
        cls.library = os.path.join(cls.tools, "fault.so")
        subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", cls.library, os.environ["BRICK_FAULT"], "-ldl"], check=True)

    def under(self, fault="", at=0):
        return mock.patch.dict(os.environ, {"LD_PRELOAD": self.library, "FAULT": fault, "FAULT_AT": str(at),
                                            "FAULT_LOG": os.path.join(self.tools, "log")})

    def count(self, *args):
        """Reads that a command takes."""
        with self.under():
            self.brick(*args)
        with open(os.path.join(self.tools, "log")) as file:
            return int(file.read())

    def test_reads_that_fail(self):
        self.brick("synth", "shells", "--size", "60x60x60", "--type", "u8", "--brick", "16", "-o", "a.brick", "--quiet")
        good = self.read("a.brick")
        opening = self.count("info", "a.brick")
        self.assertGreater(opening, 3)
        for method in METHODS:
            render = ["render", "a.brick", *method, "--size", "24x24", "--quiet", "-o", "p.exr"]
            reads = self.count(*render)
            os.remove(self.path("p.exr"))
            self.assertGreater(reads, opening + 8, method)
            for fault in ["truncate", "error", "half"]:
                for at in [opening + 1, opening + 2 + (reads - opening) // 2]:
                    with self.subTest(method=method, fault=fault, at=at), self.under(fault, at):
                        line = self.fails(1, r"brick \d+ \(level 0, \d+,\d+,\d+", *render)
                        self.assertRegex(line, "ends at byte" if fault == "truncate" else "Input/output error")
                        self.write("a.brick", good)

    def test_opening(self):
        """The same while tables are read."""
        self.brick("synth", "shells", "--size", "60x60x60", "--type", "u8", "--brick", "16", "-o", "a.brick", "--quiet")
        good = self.read("a.brick")
        opening = self.count("info", "a.brick")
        for command in [["info", "a.brick"], ["verify", "a.brick"], ["export", "a.brick", "-o", "a.raw"],
                        ["render", "a.brick", "--method", "exact", "--size", "8x8", "-o", "p.exr"]]:
            for fault in ["truncate", "error", "half"]:
                for at in range(1, opening + 1):
                    with self.subTest(command=command, fault=fault, at=at), self.under(fault, at):
                        self.fails(1, "a.brick", *command)
                        self.write("a.brick", good)


cli.main()

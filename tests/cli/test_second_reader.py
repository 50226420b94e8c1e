"""docs/second_reader.py, written from docs/FORMAT.md alone, decodes what the program writes to what it exports."""

import os
import random
import subprocess
import sys
import unittest

import cli

READER = os.environ["BRICK_SECOND_READER"]


class SecondReader(cli.Case):
    def reader(self, *args):
        return subprocess.run([sys.executable, READER, *args], cwd=self.folder, capture_output=True, text=True,
                              timeout=600)

    def agree(self, size, kind, data, *options):
        self.write("a.raw", data)
        self.brick("convert", "a.raw", "--size", size, "--type", kind, "--codec", "none", "-o", "a.brick", "--quiet",
                   *options)
        result = self.reader("a.brick", "theirs.raw")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.brick("export", "a.brick", "-o", "ours.raw")
        self.assertEqual(self.read("theirs.raw"), self.read("ours.raw"))
        self.assertEqual(result.stdout, "%d bricks decoded\n" % self.json("info", "a.brick")["bricks"])

    def test_types(self):
        source = random.Random(5)
        for kind, low, high in [("u8", 0, 255), ("i8", -128, 127), ("u16", 0, 65535), ("i16", -32768, 32767)]:
            with self.subTest(kind=kind):
                values = [source.randint(low, high) for _ in range(21 * 18 * 33)]
                self.agree("21x18x33", kind, cli.pack(kind, values), "--brick", "16", "--macrocell", "4")

    def test_floats_with_holes(self):
        source = random.Random(6)
        values = [source.gauss(0, 1e3) for _ in range(19 * 17 * 20)]
        for i in range(0, len(values), 3):
            values[i] = source.choice([float("nan"), float("inf"), -0.0, values[i]])
        for i in range(5 * 19 * 17):  # whole bricks of NaN, and two ranges apart
            values[i] = float("nan") if i < 4 * 19 * 17 else 1e6
        self.agree("19x17x20", "f32", cli.pack("f32", values), "--brick", "8", "--macrocell", "8")

    def test_constant_bricks_and_anisotropy(self):
        data = cli.pack("i16", [-1000 if i % 40 < 30 else i % 40 for i in range(40 * 20 * 24)])
        self.agree("40x20x24", "i16", data, "--brick", "8", "--spacing", "1,1,5", "--border", "3")

    def test_phantom(self):
        self.brick("synth", "ct", "--size", "48x40x36", "--type", "u16", "-o", "p.raw", "--quiet")
        self.agree("48x40x36", "u16", self.read("p.raw"))

    def test_it_notices(self):
        """A reader that accepts anything would agree too."""
        self.agree("9x8x7", "u8", bytes(range(252)) * 2)
        data = bytearray(self.read("a.brick"))
        data[512 + 200] ^= 1
        self.write("b.brick", data)
        self.assertNotEqual(self.reader("b.brick").returncode, 0)


if __name__ == "__main__":
    cli.main()

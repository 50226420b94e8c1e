"""The lossy codec from outside: the tolerance holds, is said, and every check passes."""

import math
import os
import random
import struct
import unittest

import cli

HAS_ZFP = os.environ["BRICK_ZFP"] == "1"
DIMS = (40, 36, 20)
COUNT = DIMS[0] * DIMS[1] * DIMS[2]
RAW = ["--size", "%dx%dx%d" % DIMS]


class Lossy(cli.Case):
    def convert(self, kind, values, tolerance, *options):
        self.write("a.raw", cli.pack(kind, values))
        self.brick("convert", "a.raw", *RAW, "--type", kind, "--codec", "zfp", "--tolerance", str(tolerance), "--brick",
                   "16", "-o", "a.brick", "--quiet", *options)
        self.brick("verify", "a.brick", "--quiet")
        self.brick("export", "a.brick", "-o", "b.raw", "--quiet")
        return cli.unpack(kind, self.read("b.raw"))

    @unittest.skipUnless(HAS_ZFP, "built without zfp")
    def test_tolerance(self):
        for kind, tolerance, slope in [("i16", 9, 1), ("u16", 5, -0.5), ("u8", 10, 1), ("f32", 12.5, 2)]:
            with self.subTest(kind=kind):
                noise = random.Random(1)
                values = [round(100 + 60 * math.sin(0.05 * (i % 40)) + i // 1440 + 60 * noise.random()) for i in range(COUNT)]
                back = self.convert(kind, values, tolerance, "--slope", str(slope))
                worst = max(abs(slope) * abs(a - b) for a, b in zip(values, back))
                self.assertLessEqual(worst, tolerance)
                self.assertGreater(worst, 0)
                info = self.json("info", "a.brick")
                self.assertIn("zfp", info["codecs"])
                self.assertEqual(info["tolerance"], tolerance)
                self.assertEqual(info["range"], sorted(slope * v for v in (min(back), max(back))))
                self.assertIn("zfp", info["provenance"])
                self.assertIn("no value off by more than %g" % tolerance, self.brick("info", "a.brick"))

    @unittest.skipUnless(HAS_ZFP, "built without zfp")
    def test_hard_values(self):
        infinite = [math.nan if i == 777 else math.inf if i == 9000 else 1e-42 * i if i % 7 else 1e38 for i in range(COUNT)]
        back = self.convert("f32", infinite, 1e-3)
        single = struct.unpack("<%df" % COUNT, struct.pack("<%df" % COUNT, *infinite))
        self.assertTrue(all(a == b or (a != a and b != b) or abs(a - b) <= 1e-3 for a, b in zip(single, back)))
        spikes = [65535 if i % 97 == 0 else 0 for i in range(COUNT)]
        back = self.convert("u16", spikes, 100)
        self.assertLessEqual(max(abs(a - b) for a, b in zip(spikes, back)), 100)

    @unittest.skipUnless(HAS_ZFP, "built without zfp")
    @cli.needs_gl
    def test_skipping_stays_free(self):
        """What is skipped by the ranges of a lossy file contributes nothing, at level 0 and above."""
        self.brick("synth", "ct", "--size", "70x60x50", "--type", "i16", "--brick", "16", "--macrocell", "4", "--codec",
                   "zfp", "--tolerance", "40", "-o", "a.brick", "--quiet")
        for level in ["0", "1"]:
            slabs = ["--tf", "ct-bone", "--method", "slices", "--classification", "preintegrated"]
            steps = ["--tf", "ct-bone", "--classification", "preintegrated"]
            for mode in [["--tf", "ct-bone"], ["--mode", "iso", "--iso", "300"], slabs, [*slabs, "--mode", "shaded"], steps,
                         [*steps, "--setup", "geometry"]]:
                for name, skip in [("a.exr", []), ("b.exr", ["--no-skip"])]:
                    self.brick("render", "a.brick", "--size", "64x64", "--camera", "30,20", "--level", level, "-o", name,
                               "--quiet", *mode, *skip)
                self.assertEqual(self.read("a.exr"), self.read("b.exr"))
            self.brick("render", "a.brick", "--size", "64x64", "--camera", "30,20", "--level", level, "-o", "b.exr",
                       "--quiet", *steps)
            self.assertEqual(self.read("a.exr"), self.read("b.exr"))

    def test_lossless_files_say_so(self):
        self.brick("synth", "ramp", "--size", "20x20x20", "--codec", "zstd-delta", "-o", "a.brick", "--quiet")
        info = self.json("info", "a.brick")
        self.assertEqual((info["codecs"], info["tolerance"]), (["zstd-delta"], 0))
        self.assertNotIn("off by", self.brick("info", "a.brick"))

    @unittest.skipIf(HAS_ZFP, "built with zfp")
    def test_without_the_library(self):
        self.fails(1, "libzfp-dev", "synth", "ramp", "--size", "20x20x20", "--codec", "zfp", "--tolerance", "3", "-o",
                   "a.brick", "--quiet")


cli.main()

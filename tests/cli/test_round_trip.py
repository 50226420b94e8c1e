"""export(convert(x)) == x, geometry kept, and the same file for every number of threads and memory."""

import random
import re

import cli

# Enough for several bricks and levels, and no multiple of anything.
DIMS = (37, 22, 19)
SIZE = "x".join(map(str, DIMS))
COUNT = DIMS[0] * DIMS[1] * DIMS[2]
RANGES = {"u8": (0, 255), "i8": (-128, 127), "u16": (0, 65535), "i16": (-32768, 32767)}
LAYOUT = ["--brick", "16", "--macrocell", "4", "--quiet"]


def noise(kind, seed=1):
    source = random.Random(seed)
    if kind in RANGES:
        return [source.randint(*RANGES[kind]) for _ in range(COUNT)]
    return [source.uniform(-1e4, 1e4) for _ in range(COUNT)]


def nrrd_field(data, name):
    return re.search(rb"^%s: *(.*?)\r?$" % name.encode(), data, re.M).group(1).decode()


def vectors(text):
    return [[float(x) for x in part.split(",")] for part in re.findall(r"\(([^)]*)\)", text)]


class RoundTrip(cli.Case):
    def convert(self, kind, data, *options, name="a.brick"):
        self.write("a.raw", data)
        self.brick("convert", "a.raw", "--size", SIZE, "--type", kind, "-o", name, *LAYOUT, *options)
        return name

    def test_stored_types(self):
        for kind in ["u8", "i8", "u16", "i16", "f32"]:
            data = cli.pack(kind, noise(kind))
            for codec in ["none", "lz4", "lz4-bitshuffle", "zstd", "zstd-delta"]:
                with self.subTest(kind=kind, codec=codec):
                    self.convert(kind, data, "--codec", codec)
                    self.brick("verify", "a.brick")
                    self.brick("export", "a.brick", "-o", "back.raw")
                    self.assertEqual(self.read("back.raw"), data)

    def test_special_floats(self):
        values = noise("f32")
        for i, value in enumerate([float("nan"), float("inf"), float("-inf"), -0.0, 1e-45, 3e38]):
            values[100 * i] = value
        data = cli.pack("f32", values)
        self.convert("f32", data)
        self.brick("verify", "a.brick")
        self.brick("export", "a.brick", "-o", "back.raw")
        self.assertEqual(self.read("back.raw"), data)
        self.assertEqual(self.json("info", "a.brick")["voxels_nonfinite"], 3)

    def test_endian_and_skip(self):
        values = noise("i16")
        self.convert("i16", b"header!" + cli.pack("i16", values, ">"), "--endian", "big", "--skip", "7")
        self.brick("export", "a.brick", "-o", "back.raw")
        self.assertEqual(self.read("back.raw"), cli.pack("i16", values))

    def test_wide_types_become_f32(self):
        for kind in ["u32", "i32", "f64"]:
            values = [v % 60000 for v in noise("u16")]
            self.convert(kind, cli.pack(kind, values))
            self.brick("export", "a.brick", "-o", "back.raw")
            self.assertEqual(self.read("back.raw"), cli.pack("f32", values))

    def test_affine_survives_formats(self):
        affine = [0.8, 0.1, -0.05, 12.5, -0.12, -0.9, 0.02, -340.25, 0.03, 0.07, 1.7, 1234.5]
        data = cli.pack("u16", noise("u16"))
        self.convert("u16", data, "--affine", ",".join(map(str, affine)), "--slope", "2", "--intercept", "-1000")
        for ending in ["nrrd", "mhd", "mha"]:
            with self.subTest(ending=ending):
                self.brick("export", "a.brick", "-o", "b." + ending)
                self.brick("convert", "b." + ending, "-o", "b.brick", *LAYOUT)
                info = self.json("info", "b.brick")
                for got, want in zip(info["affine"], affine):
                    self.assertAlmostEqual(got, want, delta=1e-6 * max(map(abs, affine)))
                self.brick("export", "b.brick", "-o", "back.raw")
                self.assertEqual(self.read("back.raw"), data)

    def test_region_and_level(self):
        values = noise("u16")
        self.convert("u16", cli.pack("u16", values), "--spacing", "0.5,0.5,0.5", "--origin", "10,20,30", "--axes", "LAS",
                     "--downsample", "nearest")
        (x0, x1), (y0, y1), (z0, z1) = (3, 30), (0, 22), (14, 18)
        self.brick("export", "a.brick", "-o", "part.raw", "--region", "%d:%d,%d:%d,%d:%d" % (x0, x1, y0, y1, z0, z1))
        part = [values[x + DIMS[0] * (y + DIMS[1] * z)] for z in range(z0, z1) for y in range(y0, y1)
                for x in range(x0, x1)]
        self.assertEqual(self.read("part.raw"), cli.pack("u16", part))

        # Voxel i of level 1 is voxel 2i of level 0 (nearest) and sits at 2i + 1/2.
        level = self.json("info", "a.brick")["levels"][1]
        self.assertEqual(level["dims"], [19, 11, 10])
        self.brick("export", "a.brick", "-o", "level.raw", "--level", "1", "--region", "2:19,1:11,3:4")
        want = [values[2 * x + DIMS[0] * (2 * y + DIMS[1] * 6)] for y in range(1, 11) for x in range(2, 19)]
        self.assertEqual(self.read("level.raw"), cli.pack("u16", want))

        self.brick("export", "a.brick", "-o", "level.nrrd", "--level", "1", "--region", "2:19,1:11,3:4")
        header = self.read("level.nrrd")
        self.assertEqual(nrrd_field(header, "sizes"), "17 10 1")
        self.assertEqual(vectors(nrrd_field(header, "space directions")), [[1, 0, 0], [0, -1, 0], [0, 0, 1]])
        origin = vectors(nrrd_field(header, "space origin"))[0]
        want = [10 + 0.5 * 4.5, 20 - 0.5 * 2.5, 30 + 0.5 * 6.5]
        for got, expected in zip(origin, want):
            self.assertAlmostEqual(got, expected, places=9)

    def test_determinism(self):
        data = cli.pack("i16", noise("i16"))
        self.convert("i16", data, "--threads", "1", name="one.brick")
        for options in [["--threads", "2"], ["--threads", "7"], ["--memory", "24M"]]:
            self.convert("i16", data, *options, name="many.brick")
            self.assertEqual(self.read("one.brick"), self.read("many.brick"), options)

    def test_synth(self):
        names = ["marschner-lobb", "ct", "ramp", "checker", "constant", "shells"]
        seen = set()
        for name in names:
            options = [name, "--size", "40x33x21", "--type", "i16", "--seed", "5", "--value", "17", "--quiet"]
            self.brick("synth", *options, "--threads", "1", "-o", "a.brick")
            self.brick("synth", *options, "--threads", "3", "-o", "b.brick")
            self.assertEqual(self.read("a.brick"), self.read("b.brick"), name)
            self.brick("verify", "a.brick")
            self.brick("synth", *options, "-o", "a.raw")
            self.brick("export", "a.brick", "-o", "back.raw")
            self.assertEqual(self.read("a.raw"), self.read("back.raw"), name)
            seen.add(self.read("a.raw"))
        self.assertEqual(len(seen), len(names))
        self.brick("synth", "constant", "--size", "3x3x3", "--type", "i16", "--value", "17", "-o", "c.raw")
        self.assertEqual(self.read("c.raw"), cli.pack("i16", [17] * 27))
        noisy = ["synth", "ct", "--size", "40x33x21", "--type", "i16", "-o", "c.raw", "--seed"]
        self.brick(*noisy, "1")
        first = self.read("c.raw")
        self.brick(*noisy, "2")
        self.assertNotEqual(first, self.read("c.raw"))

    @cli.needs_ct
    def test_real_ct(self):
        self.ct()
        self.brick("verify", "ct.brick")
        self.brick("export", "ct.brick", "-o", "back.raw")
        self.assertEqual(self.read("back.raw"), self.read("ct.raw"))


cli.main()

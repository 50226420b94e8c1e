"""Beyond video memory, from outside: the same file for every cache; films; levels at the same place; long axes; faults."""

import array
import json

import cli
import png

BRICK_BYTES = 36 ** 3 * 2  # of the CT's bricks, in the GPU's cache
MODES = [["dvr", "--tf", "ct-bone"], ["shaded", "--tf", "ct-skin"], ["iso", "--iso", "300"], ["mip", "--tf", "ct-bone"]]


def rows_of(data):
    """Rows of first channels."""
    width, height, channels, out = png.decode(data)
    return [out[r * width * channels:(r + 1) * width * channels:channels] for r in range(height)]


@cli.needs_gl
class Paging(cli.Case):
    @cli.needs_ct
    def test_memory_invariance(self):
        self.ct()
        for mode in MODES:
            view = ["ct.brick", "--mode", *mode, "--camera", "20,10", "--size", "96x96", "--quiet"]
            self.brick("render", *view, "-o", "all.exr")
            picture = self.read("all.exr")
            for bricks, host, threads in [(8, "1G", 2), (8, "200K", 1), (40, "4M", 2), (100, "1G", 1)]:
                with self.subTest(mode=mode, bricks=bricks, host=host):
                    limit = bricks * BRICK_BYTES
                    report = self.json("render", *view, "-o", "a.exr", "--gpu-cache", str(limit), "--host-cache", host,
                                       "--threads", str(threads))
                    self.assertEqual(self.read("a.exr"), picture)
                    self.assertGreater(report["passes"], 1)
                    self.assertLessEqual(report["gpu_cache_peak_bytes"], limit)
                    self.assertLessEqual(report["gpu_cache_bytes"], limit)
                    if host == "1G":
                        self.assertLessEqual(report["bricks_read"], report["bricks_active"])
                        # Each pass fills the cache: as many passes as bricks are times the cache, and a few.
                        self.assertLessEqual(report["passes"], 2 * report["bricks_active"] / bricks + 6)
            self.brick("render", *view, "-o", "a.exr", "--no-skip", "--gpu-cache", str(16 * BRICK_BYTES))
            self.assertEqual(self.read("a.exr"), picture)
            fast = ["render", *view, "--filter", "fast", "-o"]
            self.brick(*fast, "fast.exr")
            self.brick(*fast, "a.exr", "--gpu-cache", str(9 * BRICK_BYTES), "--threads", "1")
            self.assertEqual(self.read("a.exr"), self.read("fast.exr"))
            self.assertNotEqual(self.read("a.exr"), picture)

    def test_films(self):
        self.brick("synth", "shells", "--size", "70x60x50", "--type", "u8", "--brick", "16", "-o", "a.brick", "--quiet")
        report = self.json("render", "a.brick", "-o", "t.exr", "--turntable", "3", "--camera", "10,20", "--size", "32x32",
                           "--quiet")
        self.assertEqual(len(report["frames"]), 3)
        self.assertEqual(report["bytes_read"], sum(frame["bytes_read"] for frame in report["frames"]))
        self.assertGreater(report["frames"][0]["bytes_read"], 0)
        self.assertLess(report["frames"][2]["bricks_read"], report["frames"][0]["bricks_read"])
        self.write("path.json", json.dumps([{"azimuth": 130, "elevation": 20}, {"azimuth": 10, "elevation": 20},
                                            {"eye": [30, -200, 20], "look": [30, 30, 25], "fov": 25}]).encode())
        self.brick("render", "a.brick", "-o", "p.exr", "--path", "path.json", "--size", "32x32", "--quiet")
        self.brick("render", "a.brick", "-o", "s.exr", "--camera", "130,20", "--size", "32x32", "--quiet")
        self.brick("render", "a.brick", "-o", "e.exr", "--eye", "30,-200,20", "--look", "30,30,25", "--fov", "25", "--size",
                   "32x32", "--quiet")
        self.assertEqual(self.read("p-0000.exr"), self.read("s.exr"))
        self.assertEqual(self.read("p-0000.exr"), self.read("t-0001.exr"))
        self.assertEqual(self.read("p-0001.exr"), self.read("t-0000.exr"))
        self.assertEqual(self.read("p-0002.exr"), self.read("e.exr"))
        for text, mention in [(b"[]", "not a list"), (b"{", "not JSON"), (b'[{"azimut": 1}]', "camera 0"),
                              (b'[{"azimuth": 1}, {"eye": [1, 2]}]', "camera 1"), (b'[{"azimuth": 1e999}]', "camera 0|JSON"),
                              (b'[{"fov": 20}]', "camera 0"), (b'[{"azimuth": 1, "eye": [1, 2, 3]}]', "camera 0")]:
            self.write("bad.json", text)
            self.fails(1, mention, "render", "a.brick", "-o", "b.exr", "--path", "bad.json")
        self.fails(1, "absent.json", "render", "a.brick", "-o", "b.exr", "--path", "absent.json")
        self.fails(2, "turntable", "render", "a.brick", "-o", "b.exr", "--turntable", "2", "--path", "path.json")

    def test_budget(self):
        """Time that is up before the first brick has come leaves a picture all the same; enough time, the final one."""
        self.brick("synth", "shells", "--size", "70x60x50", "--type", "u8", "--brick", "16", "-o", "a.brick", "--quiet")
        view = ["a.brick", "--size", "40x40"]
        self.brick("render", *view, "-o", "all.exr", "--quiet")
        for seconds, final in [("1e-6", False), ("1000", True)]:
            report = self.json("render", *view, "-o", "b.exr", "-o", "b.png", "--budget", seconds, "--quiet")
            self.assertEqual(report["final"], final)
            self.assertEqual(self.read("b.exr") == self.read("all.exr"), final)
            self.assertGreater(max(pixel for row in rows_of(self.read("b.png")) for pixel in row), 30)
        self.assertTrue(self.json("render", *view, "-o", "b.exr", "--quiet")["final"])
        self.fails(2, "budget", "render", *view, "-o", "b.exr", "--method", "exact", "--budget", "1")

    def centroid(self, rows):
        total = across = down = 0.0
        for r, row in enumerate(rows):
            for c, pixel in enumerate(row):
                total += pixel
                across += pixel * c
                down += pixel * r
        self.assertGreater(total, 0)
        return across / total, down / total

    def test_levels_are_at_one_place(self):
        """A small blob: its picture's centre stays, to a quarter of a level-0 voxel, where half a voxel of level 2 would
        shift it by two. A voxel is two pixels."""
        n, values = 64, bytearray(64 ** 3)
        for z in range(n):
            for y in range(n):
                for x in range(n):
                    d = ((x - 37.0) / 9) ** 2 + ((y - 30.0) / 9) ** 2 + ((z - 26.0) / 9) ** 2
                    values[x + n * (y + n * z)] = max(0, int(200 * (1 - d)))
        self.write("blob.raw", bytes(values))
        self.brick("convert", "blob.raw", "--size", "64x64x64", "--type", "u8", "--brick", "16", "-o", "blob.brick", "--quiet")
        self.write("tf.json", b'{"unit": 1.0, "values": "physical", "points": [[0, 1, 1, 1, 0], [200, 1, 1, 1, 0.05]]}')
        for camera in ["0,0", "90,0", "0,90"]:
            centres = []
            for level in ["0", "1", "2"]:
                self.brick("render", "blob.brick", "--tf", "./tf.json", "--camera", camera, "--ortho", "64", "--level", level,
                           "--size", "128x128", "-o", "l.png", "--quiet", "--gpu-cache", "70000")
                centres.append(self.centroid(rows_of(self.read("l.png"))))
            for centre in centres[1:]:
                self.assertLess(abs(centre[0] - centres[0][0]), 0.5, camera)
                self.assertLess(abs(centre[1] - centres[0][1]), 0.5, camera)

    def test_long_axes(self):
        """70001 voxels along x, past every texture's limit: a mark near the far end is where it should be, and the picture
        is the same from a small cache."""
        nx, ny, nz = 70001, 3, 2
        row = array.array("B", bytes(nx))
        for x in range(69000, 69010):
            row[x] = 250
        self.write("long.raw", row.tobytes() * (ny * nz))
        self.brick("convert", "long.raw", "--size", "%dx%dx%d" % (nx, ny, nz), "--type", "u8", "-o", "long.brick", "--quiet")
        self.write("tf.json", b'{"unit": 1.0, "values": "physical", "points": [[100, 1, 1, 1, 0], [101, 1, 1, 1, 1]]}')
        view = ["long.brick", "--tf", "./tf.json", "--mode", "dvr", "--eye", "69004.5,-50,0.5", "--look", "69004.5,0,0.5",
                "--ortho", "20", "--size", "20x20", "--quiet"]
        self.brick("render", *view, "-o", "a.png", "-o", "a.exr")
        lit = {c for row in rows_of(self.read("a.png")) for c, pixel in enumerate(row) if pixel > 128}
        self.assertEqual(lit, set(range(5, 15)))
        # Along the axis: some 140,000 samples a ray.
        along = ["long.brick", "--tf", "./tf.json", "--eye", "-100,1,0.5", "--look", "0,1,0.5", "--ortho", "4", "--size", "4x4",
                 "--quiet"]
        for options, name in [(view, "a"), (along, "b")]:
            self.brick("render", *options, "-o", "all.exr")
            self.brick("render", *options, "-o", "few.exr", "--gpu-cache", "4K")
            self.assertEqual(self.read("all.exr"), self.read("few.exr"))
        self.brick("render", *along, "-o", "c.png")
        self.assertGreater(max(pixel for row in rows_of(self.read("c.png")) for pixel in row), 128)

    def test_faults(self):
        self.brick("synth", "shells", "--size", "100x100x100", "--type", "u8", "--brick", "16", "-o", "a.brick", "--quiet")
        data = bytearray(self.read("a.brick"))
        data[len(data) // 2] ^= 1
        self.write("flipped.brick", bytes(data))
        for cache in ["64M", "70K"]:
            self.fails(1, "brick [0-9]+", "render", "flipped.brick", "-o", "b.exr", "--mode", "mip", "--gpu-cache", cache,
                       "--size", "64x64")


cli.main()

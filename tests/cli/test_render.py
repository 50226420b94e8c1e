"""Pictures of small synthetic volumes: what must not change them, and the two contexts against each other."""

import os
import struct
import zlib

import cli

MODES = [["dvr"], ["shaded"], ["iso", "--iso", "128"], ["mip"]]


def png_pixels(data):
    """Width, height and rows of an 8-bit RGB or RGBA PNG whose filters are all decoded here."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        n, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + n]
        at += 12 + n
    assert depth == 8 and colour in (2, 6)
    size = 3 if colour == 2 else 4
    raw, rows, above = zlib.decompress(packed), [], [0] * (width * size)
    for r in range(height):
        line = raw[r * (width * size + 1):(r + 1) * (width * size + 1)]
        row = []
        for i, byte in enumerate(line[1:]):
            left = row[i - size] if i >= size else 0
            up, corner = above[i], above[i - size] if i >= size else 0
            p = left + up - corner
            paeth = min((abs(p - left), 0, left), (abs(p - up), 1, up), (abs(p - corner), 2, corner))[2]
            row.append((byte + [0, left, up, (left + up) // 2, paeth][line[0]]) & 255)
        rows.append([tuple(row[i:i + size]) for i in range(0, len(row), size)])
        above = row
    return width, height, rows


class Render(cli.Case):
    def setUp(self):
        super().setUp()
        self.brick("synth", "shells", "--size", "70x60x50", "--type", "u8", "--brick", "16", "-o", "a.brick", "--quiet")

    def render(self, name, *options, volume="a.brick"):
        self.brick("render", volume, "-o", name, "--size", "64x48", "--quiet", *options)
        return self.read(name)

    @cli.needs_gl
    def test_speed_options_change_nothing(self):
        for mode in MODES:
            options = ["--mode", *mode, "--camera", "30,20"]
            plain = self.render("plain.exr", *options)
            for variant in [["--no-skip"], ["--threads", "1"], ["--threads", "3"], ["--host-cache", "4M"],
                            ["--gpu-cache", "64M"]]:
                with self.subTest(mode=mode, variant=variant):
                    self.assertEqual(self.render("b.exr", *options, *variant), plain)

    @cli.needs_gl
    def test_preintegrated(self):
        options = ["--classification", "preintegrated", "--camera", "30,20", "--mode", "shaded"]
        plain = self.render("plain.exr", *options)
        self.assertNotEqual(plain, self.render("post.exr", *options[2:]))
        self.assertEqual(self.render("b.exr", *options, "--no-skip", "--gpu-cache", "64K"), plain)
        self.fails(1, "up to 1 voxel edges", "render", "a.brick", "-o", "no.exr", *options, "--step", "1.5")
        self.assertFalse(os.path.exists(self.path("no.exr")))

    @cli.needs_gl
    def test_termination(self):
        self.render("never.exr", "--termination", "0")
        for t in ["0.1", "0.01", "0.0001"]:
            self.render("early.exr", "--termination", t)
            self.assertLessEqual(self.json("compare", "early.exr", "never.exr")["max_abs"], float(t))

    @cli.needs_egl_and_osmesa
    def test_egl_and_osmesa(self):
        for mode in MODES:
            self.render("egl.exr", "--mode", *mode, "--context", "egl")
            self.render("osmesa.exr", "--mode", *mode, "--context", "osmesa")
            self.assertLessEqual(self.json("compare", "egl.exr", "osmesa.exr")["max_abs"], 1e-5, mode)

    @cli.needs_exr
    def test_without_opengl(self):
        """The processor draws what llvmpipe draws, and says what it does not draw."""
        for mode in ["dvr", "shaded", "mip"]:
            options = ["--mode", mode, "--camera", "30,20", "--clip", "0,0,1,-10"]
            plain = self.render("cpu.exr", *options, "--context", "cpu")
            self.assertEqual(self.render("small.exr", *options, "--context", "cpu", "--host-cache", "30K"), plain)
            if cli.HAS_EGL:
                report = self.json("render", "a.brick", "-o", "egl.exr", "--size", "64x48", *options, "--context", "egl")
                if "llvmpipe" in report["gl_renderer"]:
                    self.assertEqual(self.read("egl.exr"), plain, mode)
                self.assertLessEqual(self.json("compare", "cpu.exr", "egl.exr")["max_abs"], 1e-5, mode)
        no = ["render", "a.brick", "-o", "no.exr", "--context", "cpu"]
        self.fails(1, "isotrace", *no, "--mode", "iso", "--iso", "20")
        self.fails(1, "needs OpenGL", *no, "--method", "slices")
        self.fails(1, "after interpolation", *no, "--classification", "preintegrated")
        self.fails(1, "geometry", *no, "--setup", "geometry")
        self.fails(1, "fast filter", *no, "--filter", "fast")
        self.fails(2, "--gpu-cache", *no, "--gpu-cache", "1M")
        self.fails(2, "--budget", *no, "--budget", "1")
        self.assertFalse(os.path.exists(self.path("no.exr")))

    @cli.needs_gl
    def test_report(self):
        report = self.json("render", "a.brick", "-o", "a.exr", "-o", "a.png", "--size", "64x48", "--quiet")
        for field in ["seconds_total", "seconds_frame", "passes", "bricks_total", "bricks_active", "bricks_loaded",
                      "bytes_read", "gpu_cache_bytes", "gpu_cache_peak_bytes", "samples", "gl_renderer"]:
            self.assertIn(field, report)
        self.assertGreater(report["bricks_active"], 0)
        self.assertLessEqual(report["bricks_active"], report["bricks_total"])
        self.assertLessEqual(report["bricks_loaded"], report["bricks_active"])
        self.assertGreater(report["samples"], 0)
        self.assertEqual(png_pixels(self.read("a.png"))[:2], (64, 48))

    @cli.needs_gl
    def test_cache_too_small(self):
        """One brick is 20^3 bytes."""
        for cache in ["--gpu-cache", "--host-cache"]:
            self.fails(1, "cache.*7000 bytes.*one brick", "render", "a.brick", "-o", "a.exr", cache, "7000", "--size", "32x32")

    @cli.needs_exr
    def test_background_and_constant_slab(self):
        """A transfer function opaque nowhere shows the background; linear 0.5 is 188 in sRGB."""
        self.write("clear.json", b'{"unit": 1.0, "values": "physical", "points": [[0, 1, 1, 1, 0]]}')
        self.brick("render", "a.brick", "-o", "a.png", "--method", "exact", "--tf", "./clear.json", "--background",
                   "0.5,0,1", "--size", "5x4", "--quiet")
        width, height, rows = png_pixels(self.read("a.png"))
        self.assertEqual((width, height), (5, 4))
        self.assertEqual({pixel[:3] for row in rows for pixel in row}, {(188, 0, 255)})

    @cli.needs_exr
    def test_picture_is_not_mirrored(self):
        """One bright corner of the volume: at small x (R), large z (S), seen from the front. The viewer faces the
        patient, so the patient's right is on the left of the picture, and superior is on top."""
        dims, values = (16, 16, 16), [0] * 4096
        for z in range(11, 16):
            for y in range(16):
                for x in range(5):
                    values[x + 16 * (y + 16 * z)] = 200
        self.write("corner.raw", cli.pack("u8", values))
        self.brick("convert", "corner.raw", "--size", "16x16x16", "--type", "u8", "-o", "corner.brick", "--quiet")
        self.write("tf.json", b'{"unit": 1.0, "values": "physical", "points": [[0, 1, 1, 1, 0], [200, 1, 1, 1, 0.9]]}')
        for camera, quarter in [("0,0", (0, 0)), ("180,0", (0, 1))]:
            self.brick("render", "corner.brick", "-o", "corner.png", "--method", "exact", "--tf", "./tf.json", "--camera",
                       camera, "--ortho", "16", "--size", "16x16", "--quiet")
            rows = png_pixels(self.read("corner.png"))[2]
            bright = [(r // 8, c // 8) for r in range(16) for c in range(16) if rows[r][c][0] > 128]
            self.assertTrue(bright)
            self.assertEqual(set(bright), {quarter}, camera)

    @cli.needs_exr
    def test_isotrace(self):
        """What must not change the picture, and that surfaces, opacities, light and shadows do."""
        options = ["--method", "isotrace", "--mode", "iso", "--iso", "100,160", "--iso-opacity", "0.3,0.8", "--camera",
                   "30,20"]
        plain = self.render("plain.exr", *options)
        for variant in [["--no-skip"], ["--threads", "1"], ["--threads", "3"], ["--host-cache", "100K"]]:
            with self.subTest(variant=variant):
                self.assertEqual(self.render("b.exr", *options, *variant), plain)
        seen = {plain}
        for variant in [["--iso-opacity", "0.4,0.8"], ["--iso", "90,160"], ["--shadows"], ["--light", "1,0,1"],
                        ["--light", "1,0,1", "--shadows"], ["--tf", "ct-bone"], ["--level", "1"]]:
            with self.subTest(variant=variant):
                picture = self.render("b.exr", *options, *variant)
                self.assertNotIn(picture, seen)
                seen.add(picture)
        report = self.json("render", "a.brick", "-o", "a.exr", "--size", "64x48", "--quiet", *options)
        self.assertGreater(report["samples"], 0)
        self.assertLessEqual(report["bricks_loaded"], report["bricks_active"])

    @cli.needs_gl
    def test_isotrace_is_raycast_in_the_limit(self):
        """The same surface, colour and light. No silhouette of a sphere is grazed by these rays to within a step."""
        options = ["--mode", "iso", "--iso", "128", "--camera", "30,20"]
        self.render("traced.exr", *options, "--method", "isotrace")
        self.render("cast.exr", *options, "--step", "0.02", "--refinements", "16")
        self.assertLess(self.json("compare", "traced.exr", "cast.exr")["max_abs"], 1e-4)

    def test_bench_isotrace(self):
        bench = self.json("bench", "isotrace", "a.brick", "--frames", "2", "--size", "64x48", "--iso", "128")
        self.assertAlmostEqual(sum(bench["share_percent"].values()), 100, places=6)
        for seconds in [*bench["seconds"].values(), *bench["seconds_cores"]]:
            self.assertGreater(seconds, 0)

    @cli.needs_gl
    def test_bench(self):
        bench = self.json("bench", "render", "a.brick", "--frames", "1", "--size", "32x32", "--iso", "128")
        for mode in ["dvr", "shaded", "iso", "mip", "isotrace"]:
            self.assertGreater(bench[mode]["seconds_frame"], 0)

    def test_bench_convert(self):
        self.write("a.raw", bytes(64 * 64 * 64))
        bench = self.json("bench", "convert", "a.raw", "--size", "64x64x64", "--type", "u8", "--repeat", "2")
        self.assertGreater(bench["speed_of_copy"], 0)
        self.assertEqual(bench["source_bytes"], 64 ** 3)


cli.main()

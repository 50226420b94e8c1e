"""Sizes that no one has, and shapes that hardly anyone has: refused in one line before memory is taken, or handled in
memory that is bounded."""

import os
import subprocess

import cli

BRICKS = 2097151  # of all levels: 2^20 at level 0, halved down to one
INDEX_BYTES = 48 * BRICKS


class Hostile(cli.Case):
    def peak_bytes(self, *args):
        """Run, must succeed; the peak of its resident memory."""
        with open(self.path("said"), "w") as said:
            child = subprocess.Popen([cli.BRICK, *args], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=said,
                                     stderr=said)
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
        with open(self.path("said")) as said:
            self.assertEqual(child.returncode, 0, "brick %s: %s" % (" ".join(args), said.read()))
        return usage.ru_maxrss * 1024

    def test_sizes(self):
        self.write("a.raw", bytes(100))
        for size in ["2147483647x1x1", "2147483648x2x1", "1x4294967296x1", "1099511627776x1x1",
                     "1099511627776x1099511627776x1099511627776"]:
            self.fails(1, "a.raw.*(size|many|large)", "convert", "a.raw", "--size", size, "--type", "u8", "-o", "a.brick")
        for size in [2 ** 63 - 1, 2 ** 63, 2 ** 64 - 1, 2 ** 64, 2 ** 40 + 1]:
            self.fails(2, "--size", "convert", "a.raw", "--size", "%dx1x1" % size, "--type", "u8", "-o", "a.brick")
            self.fails(2, "--size", "synth", "ct", "--size", "1x1x%d" % size, "-o", "a.brick")
        self.fails(1, "memory|MiB", "synth", "ct", "--size", "x".join(["131072"] * 3), "-o", "a.brick")
        for sizes in ["2147483647 1 1", "2147483648 4 4", "1 1 9223372036854775807", "9223372036854775807 2 1",
                      "4294967296 4294967296 1", "18446744073709551615 1 1", "18446744073709551616 1 1", "-1 1 1"]:
            with self.subTest(sizes=sizes):
                self.write("h.nrrd", b"NRRD0004\ntype: short\ndimension: 3\nsizes: %s\nencoding: raw\nendian: little\n\nxx"
                           % sizes.encode())
                self.fails(1, "h.nrrd", "convert", "h.nrrd", "-o", "a.brick")
                self.write("h.mha", b"NDims = 3\nDimSize = %s\nElementType = MET_SHORT\nElementDataFile = LOCAL\nxx"
                           % sizes.encode())
                self.fails(1, "h.mha", "convert", "h.mha", "-o", "a.brick")

    def test_no_spacing(self):
        self.write("h.nrrd", b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 0 1\nencoding: raw\n\n12345678")
        self.fails(1, "h.nrrd: .*spacing", "convert", "h.nrrd", "-o", "a.brick")
        self.write("h.nrrd", b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspace: LPS\n"
                             b"space directions: (1,0,0) (0,0,0) (0,0,1)\nencoding: raw\n\n12345678")
        self.fails(1, "h.nrrd: .*spacing", "convert", "h.nrrd", "-o", "a.brick")
        self.write("h.mha", b"NDims = 3\nDimSize = 2 2 2\nElementSpacing = 1 1 0\nElementType = MET_UCHAR\n"
                            b"ElementDataFile = LOCAL\n12345678")
        self.fails(1, "h.mha: .*spacing", "convert", "h.mha", "-o", "a.brick")

    def test_a_needle(self):
        """1 x 1 x 10^6 voxels."""
        voxels = bytes((i // 1000 * 37 + i % 7) & 255 for i in range(10 ** 6))
        self.write("a.raw", voxels)
        self.brick("convert", "a.raw", "--size", "1x1x1000000", "--type", "u8", "-o", "a.brick", "--quiet")
        self.brick("verify", "a.brick", "--quiet")
        self.assertEqual(self.json("info", "a.brick")["dims"], [1, 1, 10 ** 6])
        self.brick("export", "a.brick", "-o", "b.raw", "--quiet")
        self.assertEqual(self.read("b.raw"), voxels)
        self.brick("repair", "a.brick", "-o", "b.brick", "--quiet")
        self.assertEqual(self.read("a.brick"), self.read("b.brick"))
        self.render("a.brick", "0,-50,70000", "0,0,70000")

    def render(self, path, eye, look):
        """From beside, by every method that there is; raycast agrees with exact. Peaks of memory."""
        view = [path, "--eye", eye, "--look", look, "--ortho", "40", "--size", "16x16", "--tf", "gray", "--quiet"]
        peaks = []
        if cli.HAS_EXR:
            peaks.append(self.peak_bytes("render", *view, "--method", "exact", "-o", "exact.exr"))
        if cli.HAS_EGL or cli.HAS_OSMESA:
            peaks.append(self.peak_bytes("render", *view, "--step", "0.125", "-o", "a.exr"))
            self.assertLess(self.json("compare", "a.exr", "exact.exr")["max_abs"], 0.01)
        return peaks

    def test_two_million_bricks(self):
        n = 8 * (BRICKS + 1) // 2
        voxels = bytearray(n)
        for i in range(0, n, 4096):
            voxels[i:i + 300] = bytes((j * 7) & 255 for j in range(300))
        self.write("a.raw", bytes(voxels))
        self.brick("convert", "a.raw", "--size", "%dx1x1" % n, "--type", "u8", "--brick", "8", "-o", "a.brick", "--quiet")
        room = INDEX_BYTES + (64 << 20)
        # Reading holds the index; info and verify some more for each brick, repair and the renderer a second index' worth.
        self.assertLess(self.peak_bytes("info", "a.brick"), 2 * room)
        self.assertIn('"bricks": %d' % BRICKS, self.brick("verify", "a.brick", "--json").replace(":\t", ": "))
        self.assertLess(self.peak_bytes("verify", "a.brick"), 2 * room)
        self.assertLess(self.peak_bytes("repair", "a.brick", "-o", "b.brick"), 512 << 20)
        self.assertEqual(self.read("a.brick"), self.read("b.brick"))
        for peak in self.render("a.brick", "4096200,-50,0", "4096200,0,0"):
            self.assertLess(peak, 1 << 30)


cli.main()

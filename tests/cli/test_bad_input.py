"""What people do wrong and what disks do: one line that says what, the right exit code, and no file left."""

import os
import shutil
import subprocess

import cli

NRRD = b"NRRD0004\ntype: short\ndimension: 3\nsizes: %s\nencoding: raw\nendian: little\n\n"


class BadInput(cli.Case):
    def small(self):
        """A good file to start from."""
        self.write("small.raw", bytes(range(64)))
        self.brick("convert", "small.raw", "--size", "4x4x4", "--type", "u8", "-o", "small.brick", "--quiet")
        return "small.brick"

    def test_missing_file(self):
        self.fails(1, "missing.nrrd", "convert", "missing.nrrd", "-o", "a.brick")
        self.fails(1, "missing.raw", "convert", "missing.raw", "--size", "4x4x4", "--type", "u8", "-o", "a.brick")
        self.fails(1, "missing.brick", "info", "missing.brick")
        self.fails(1, "missing.brick", "verify", "missing.brick")
        self.fails(1, "missing.brick", "export", "missing.brick", "-o", "a.raw")
        self.fails(1, "missing.exr" if cli.HAS_EXR else "OpenEXR", "compare", "missing.exr", "missing.exr")
        if cli.HAS_EXR:
            self.fails(1, "missing.brick", "render", "missing.brick", "-o", "a.exr")
            self.fails(1, "missing.json", "render", self.small(), "-o", "a.exr", "--tf", "missing.json")
        self.fails(1, "nowhere", "info", self.small(), "--tf", "nowhere")
        os.mkdir(self.path("folder.brick"))
        self.fails(1, "folder.brick", "info", "folder.brick")

    def test_wrong_size(self):
        self.write("a.raw", bytes(1000))
        for size in ["10x10x11", "10x10x9"]:
            self.fails(1, "a.raw.*(990|900|1100|1000)", "convert", "a.raw", "--size", size, "--type", "u8", "-o", "a.brick")
        self.fails(1, "a.raw", "convert", "a.raw", "--size", "10x10x10", "--type", "u16", "-o", "a.brick")
        self.fails(1, "a.raw", "convert", "a.raw", "--size", "10x10x10", "--type", "u8", "--skip", "1", "-o", "a.brick")
        # 2^40 voxels an axis: the product does not fit 64 bits.
        huge = "x".join([str(1 << 40)] * 3)
        self.fails(1, "large|size|bytes|overflow|many", "convert", "a.raw", "--size", huge, "--type", "u8", "-o", "a.brick")

    def test_truncated_nrrd(self):
        data = NRRD % b"8 8 8" + bytes(8 * 8 * 8 * 2)
        self.write("good.nrrd", data)
        self.brick("convert", "good.nrrd", "-o", "good.brick", "--quiet")
        self.write("short.nrrd", data[:-1])
        self.fails(1, "short.nrrd", "convert", "short.nrrd", "-o", "a.brick")
        self.write("header.nrrd", data[:40])
        self.fails(1, "header.nrrd", "convert", "header.nrrd", "-o", "a.brick")
        self.write("empty.nrrd", b"")
        self.fails(1, "empty.nrrd", "convert", "empty.nrrd", "-o", "a.brick")

    def test_nothing_finite(self):
        self.write("nan.raw", cli.pack("f32", [float("nan")] * 1000))
        result = self.run_brick("convert", "nan.raw", "--size", "10x10x10", "--type", "f32", "-o", "nan.brick", "--quiet")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn("no voxel is finite", result.stderr)
        self.brick("verify", "nan.brick")
        self.assertEqual(self.json("info", "nan.brick", "--tf", "gray")["bricks_active"], 0)
        self.assertEqual(self.json("info", "nan.brick")["voxels_nonfinite"], 1000)
        self.assertIn("1000 of 1000", self.brick("info", "nan.brick"))
        self.brick("export", "nan.brick", "-o", "back.raw")
        self.assertEqual(self.read("back.raw"), self.read("nan.raw"))
        if cli.HAS_EXR:
            self.brick("render", "nan.brick", "--method", "exact", "--size", "8x8", "-o", "exact.exr")
        if cli.HAS_EGL or cli.HAS_OSMESA:
            for mode in [["dvr"], ["shaded"], ["iso", "--iso", "1"], ["mip"]]:
                self.brick("render", "nan.brick", "--mode", *mode, "--size", "8x8", "-o", "nan.exr")
                self.assertEqual(self.json("compare", "nan.exr", "exact.exr")["max_abs"], 0, mode)

    def test_unknown_ending(self):
        self.write("a.foo", bytes(64))
        self.fails(1, "a.foo.*nrrd", "convert", "a.foo", "-o", "a.brick")
        self.fails(1, "b.foo", "export", self.small(), "-o", "b.foo")
        self.fails(1, "b.foo", "render", self.small(), "-o", "b.foo", "--size", "8x8")
        self.fails(1, "b.foo", "synth", "ramp", "--size", "4x4x4", "-o", "b.foo")
        self.fails(1, "a.foo", "info", "a.foo")

    def test_zero_sized_axis(self):
        self.write("a.raw", b"")
        self.fails(2, "0 voxels", "convert", "a.raw", "--size", "4x0x4", "--type", "u8", "-o", "a.brick")
        self.write("zero.nrrd", NRRD % b"4 0 4")
        self.fails(1, "zero.nrrd", "convert", "zero.nrrd", "-o", "a.brick")

    def test_one_voxel(self):
        self.write("one.raw", cli.pack("i16", [-7]))
        self.brick("convert", "one.raw", "--size", "1x1x1", "--type", "i16", "-o", "one.brick", "--quiet")
        self.brick("verify", "one.brick")
        info = self.json("info", "one.brick")
        self.assertEqual((info["dims"], info["range"], len(info["levels"])), ([1, 1, 1], [-7, -7], 1))
        self.brick("export", "one.brick", "-o", "back.raw")
        self.assertEqual(self.read("back.raw"), self.read("one.raw"))
        if cli.HAS_EXR:
            self.brick("render", "one.brick", "--method", "exact", "--size", "8x8", "-o", "one.exr")
        if cli.HAS_EGL or cli.HAS_OSMESA:
            for mode in [["dvr"], ["shaded"], ["iso", "--iso", "-8"], ["mip"]]:
                self.brick("render", "one.brick", "--mode", *mode, "--size", "8x8", "-o", "one.exr")

    def test_no_such_folder(self):
        small = self.small()
        self.fails(1, "nowhere", "convert", "small.raw", "--size", "4x4x4", "--type", "u8", "-o", "nowhere/a.brick")
        self.fails(1, "nowhere", "synth", "ramp", "--size", "4x4x4", "-o", "nowhere/a.brick")
        self.fails(1, "nowhere", "synth", "ramp", "--size", "4x4x4", "-o", "nowhere/a.nrrd")
        self.fails(1, "nowhere", "export", small, "-o", "nowhere/a.raw")
        if cli.HAS_EXR:
            self.fails(1, "nowhere", "render", small, "-o", "nowhere/a.exr")

    def test_region_and_level_outside(self):
        small = self.small()
        self.fails(1, "level", "export", small, "-o", "a.raw", "--level", "9")
        self.fails(1, "region", "export", small, "-o", "a.raw", "--region", "0:5,0:4,0:4")

    def test_inexact(self):
        self.write("a.raw", cli.pack("u32", [16777217] + [0] * 7))
        options = ["a.raw", "--size", "2x2x2", "--type", "u32", "-o", "a.brick", "--quiet"]
        self.fails(1, "f32", "convert", *options)
        result = self.run_brick("convert", *options, "--to", "f32")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn("f32", result.stderr)


class FullDisk(cli.Case):
    """A small tmpfs in a mount namespace of its own, so that nothing stays mounted."""

    SCRIPT = 'mount -t tmpfs -o size=128k none "$1" || exit 77; d=$1; shift; "$@"; code=$?; ls -A "$d"; exit $code'

    def full(self, *args, left=""):
        os.makedirs(self.path("disk"), exist_ok=True)
        unshare = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
        if not shutil.which("unshare"):
            self.skipTest("no unshare")
        result = subprocess.run([*unshare, "sh", "-c", self.SCRIPT, "sh", "disk", cli.BRICK, *args], cwd=self.folder,
                                capture_output=True, text=True, timeout=300)
        if result.returncode == 77 or result.stderr.startswith("unshare:"):
            self.skipTest("cannot mount a tmpfs here")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertRegex(result.stderr, "^brick %s: .*(No space left|disk is full|disk full)" % args[0])
        self.assertEqual(result.stdout, left, "files were left")
        self.assertEqual("--resume" in result.stderr, bool(left))

    def test_convert(self):
        self.write("a.raw", os.urandom(1 << 20))
        self.full("convert", "a.raw", "--size", "128x128x64", "--type", "u8", "-o", "disk/a.brick", "--quiet",
                  left="a.brick.part\na.brick.part.journal\na.brick.part.levels\n")

    def test_export(self):
        self.write("a.raw", os.urandom(1 << 20))
        self.brick("convert", "a.raw", "--size", "128x128x64", "--type", "u8", "-o", "a.brick", "--quiet")
        for ending in ["raw", "nrrd", "mhd"]:
            self.full("export", "a.brick", "-o", "disk/a." + ending)

    @cli.needs_exr
    def test_render(self):
        self.write("a.raw", os.urandom(4096))
        self.brick("convert", "a.raw", "--size", "16x16x16", "--type", "u8", "-o", "a.brick", "--quiet")
        self.full("render", "a.brick", "--method", "exact", "--size", "256x256", "-o", "disk/a.exr", "--quiet")


cli.main()

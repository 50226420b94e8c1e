"""Help, version, and wrong usage: exit code 2, one line, nothing written."""

import os
import re

import cli

COMMANDS = ["convert", "info", "verify", "repair", "export", "render", "compare", "synth", "bench render", "bench hits",
            "bench features", "bench isotrace", "bench convert",
            "bench codecs"]


class Usage(cli.Case):
    def test_help(self):
        listing = self.brick("help")
        for command in COMMANDS:
            self.assertIn(command.split()[0], listing)
            text = self.brick(*command.split(), "--help")
            self.assertTrue(text.startswith("usage: brick " + command), text)
        self.assertEqual(self.brick("help", "convert"), self.brick("convert", "--help"))
        self.assertRegex(self.brick("--version"), r"^brick \d+\.\d+\.\d+\n$")

    def test_man_page_lists_every_option(self):
        with open(os.environ["BRICK_MAN"]) as file:
            page = file.read().replace("\\-", "-")
        for command in COMMANDS:
            section = re.search(r'^\.SS "?brick %s\b.*?(?=^\.S[SH] |\Z)' % command, page, re.M | re.S)
            self.assertTrue(section, command)
            for option in re.findall(r"^  (?:-\w, |    )--([a-z-]+)", self.brick(*command.split(), "--help"), re.M):
                if option != "help":
                    self.assertIn("--" + option, section.group(), command)

    def test_commands(self):
        self.fails(2, "did you mean 'render'", "rendre")
        self.fails(2, "unknown command", "frobnicate")
        self.fails(2, "measurement", "bench", "everything")
        self.assertEqual(self.run_brick().returncode, 2)

    def test_garbage_values(self):
        self.write("a.raw", bytes(64))
        good = {"--size": "4x4x4", "--type": "u8"}
        for option, value in [
            ("--size", "4x4"), ("--size", "4x4x4x"), ("--size", "4x-4x4"), ("--size", " 4x4x4"), ("--size", "0x4x4"),
            ("--size", "99999999999999999999x1x1"), ("--type", "int"), ("--endian", "middle"), ("--skip", "12Q"),
            ("--spacing", "1,1"), ("--spacing", "1,1,0"), ("--spacing", "1,1,nan"), ("--spacing", "1,1,1,"),
            ("--origin", "a,b,c"), ("--axes", "LPX"), ("--axes", "LLS"), ("--axes", "LPSA"), ("--slope", "0"),
            ("--affine", "1,0,0,0,0,1,0,0,0,0,1"), ("--intercept", "1e999"), ("--brick", "3"), ("--brick", "x"),
            ("--codec", "zip"), ("--tolerance", "0"), ("--tolerance", "-1"), ("--tolerance", "nan"), ("--codec-level", "10"), ("--downsample", "max"), ("--memory", "5 G"),
            ("--threads", "0"), ("--to", "u8"), ("--memory", "99999999999999T"),
        ]:
            with self.subTest(option=option, value=value):
                options = {**good, option: value}
                self.fails(2, option + "|slope", "convert", "a.raw", "-o", "a.brick",
                           *[word for pair in options.items() for word in pair])
        for options in [["--size", "0x8"], ["--size", "8"], ["--step", "0"], ["--step", "-1"], ["--camera", "1"],
                        ["--fov", "180"], ["--ortho", "0"], ["--background", "2,0,0"], ["--mode", "xray"],
                        ["--iso", "1,,2"], ["--iso", "1,"], ["--iso", ",".join("1" * 17)], ["--iso-opacity", "1.5"],
                        ["--light", "1,2"], ["--context", "glx"], ["--method", "fast"], ["--filter", "cubic"]]:
            with self.subTest(options=options):
                self.fails(2, options[0], "render", "a.brick", "-o", "a.png", *options)
        for region in ["0:1,0:1", "1:1,0:1,0:1", "2:1,0:1,0:1", "0:1,0:1,0:1,0:1", "0-1,0-1,0-1", "-1:1,0:1,0:1"]:
            with self.subTest(region=region):
                self.fails(2, "--region", "export", "a.brick", "-o", "b.raw", "--region", region)

    def test_combinations(self):
        self.write("a.raw", bytes(64))
        raw = ["a.raw", "--size", "4x4x4", "--type", "u8", "-o", "a.brick"]
        for mention, args in [
            ("one src", ["convert", "-o", "a.brick"]),
            ("too many", ["convert", "a.raw", "b.raw", "-o", "a.brick"]),
            ("no output", ["convert", "a.raw"]),
            ("end in .brick", ["convert", *raw[:-1], "a.raw"]),
            ("go together", ["convert", "a.raw", "--size", "4x4x4", "-o", "a.brick"]),
            ("--affine", ["convert", *raw, "--affine", "1,0,0,0,0,1,0,0,0,0,1,0", "--axes", "RAS"]),
            ("needs --tolerance", ["convert", *raw, "--codec", "zfp"]),
            ("--codec zfp", ["convert", *raw, "--tolerance", "1"]),
            ("needs --tolerance", ["synth", "ct", "--size", "4x4x4", "--codec", "zfp", "-o", "a.brick"]),
            ("needs a value", ["convert", *raw, "--spacing"]),
            ("--frobnicate", ["convert", *raw, "--frobnicate"]),
            ("--quiet=1", ["convert", *raw, "--quiet=1"]),
            ("needs --iso", ["render", "a.brick", "-o", "a.exr", "--mode", "iso"]),
            ("--mode iso", ["render", "a.brick", "-o", "a.exr", "--iso", "3"]),
            ("--refinements", ["render", "a.brick", "-o", "a.exr", "--refinements", "3"]),
            ("--camera", ["render", "a.brick", "-o", "a.exr", "--camera", "0,0", "--eye", "1,2,3"]),
            ("--eye", ["render", "a.brick", "-o", "a.exr", "--look", "1,2,3"]),
            ("--ortho", ["render", "a.brick", "-o", "a.exr", "--fov", "30", "--ortho", "100"]),
            ("exact", ["render", "a.brick", "-o", "a.exr", "--method", "exact", "--mode", "iso", "--iso", "1",
                       "--refinements", "3"]),
            ("preclassified", ["render", "a.brick", "-o", "a.exr", "--method", "exact", "--mode", "mip", "--field",
                               "preclassified"]),
            ("--field", ["render", "a.brick", "-o", "a.exr", "--field", "tetrahedra"]),
            ("six numbers", ["render", "a.brick", "-o", "a.exr", "--clip-box", "0,1,0,1,0"]),
            ("start", ["render", "a.brick", "-o", "a.exr", "--clip-box", "0,1,0,1,2,1"]),
            ("four numbers", ["render", "a.brick", "-o", "a.exr", "--method", "exact", "--clip", "1,0,0"]),
            ("normal", ["render", "a.brick", "-o", "a.exr", "--method", "exact", "--clip", "0,0,0,1"]),
            ("12 clip planes", ["render", "a.brick", "-o", "a.exr", *["--clip", "1,0,0,5"] * 7, "--clip-box",
                                "0,1,0,1,0,1"]),
            ("exact", ["render", "a.brick", "-o", "a.exr", "--method", "exact", "--step", "0.5"]),
            ("exact", ["render", "a.brick", "-o", "a.exr", "--method", "exact", "--context", "egl"]),
            ("--mode iso only", ["render", "a.brick", "-o", "a.exr", "--method", "isotrace"]),
            ("as many", ["render", "a.brick", "-o", "a.exr", "--method", "isotrace", "--mode", "iso", "--iso", "1,2",
                         "--iso-opacity", "1"]),
            ("--step", ["render", "a.brick", "-o", "a.exr", "--method", "isotrace", "--mode", "iso", "--iso", "1",
                        "--step", "1"]),
            ("--context", ["render", "a.brick", "-o", "a.exr", "--method", "isotrace", "--mode", "iso", "--iso", "1",
                           "--context", "egl"]),
            ("isotrace", ["render", "a.brick", "-o", "a.exr", "--mode", "iso", "--iso", "1,2"]),
            ("isotrace", ["render", "a.brick", "-o", "a.exr", "--mode", "iso", "--iso", "1", "--shadows"]),
            ("isotrace", ["render", "a.brick", "-o", "a.exr", "--mode", "iso", "--iso", "1", "--light", "1,0,0"]),
            ("dvr or shaded", ["render", "a.brick", "-o", "a.exr", "--mode", "mip", "--classification", "preintegrated"]),
            ("GPU", ["render", "a.brick", "-o", "a.exr", "--method", "exact", "--classification", "post"]),
            ("--method slices", ["render", "a.brick", "-o", "a.exr", "--classification", "pre"]),
            ("no output", ["render", "a.brick"]),
            ("two pictures", ["compare", "a.exr"]),
            ("no size", ["synth", "ct", "-o", "a.brick"]),
            ("unknown field", ["synth", "cat", "--size", "4x4x4", "-o", "a.brick"]),
            ("--type", ["synth", "ct", "--size", "4x4x4", "--type", "f64", "-o", "a.brick"]),
            ("no output", ["export", "a.brick"]),
        ]:
            with self.subTest(args=args):
                self.fails(2, mention, *args)

    def test_stdout_that_cannot_be_written(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full")
        import subprocess
        with open("/dev/full", "w") as full:
            result = subprocess.run([cli.BRICK, "help"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("stdout", result.stderr)


cli.main()

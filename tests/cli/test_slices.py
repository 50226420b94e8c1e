"""Slices on the real CT and on Marschner-Lobb: as wrong as their step and precision allow, whatever the caches."""

import json
import os

import cli

BONE = ["--tf", "ct-bone", "--size", "128x128", "--camera", "20,10", "--ortho", "240", "--quiet"]


class Slices(cli.Case):
    def errors(self, view, exact, steps, *options):
        """RMSE against the exact picture, by step."""
        self.brick("render", *view, "--method", "exact", *exact, "-o", "exact.exr")
        errors = []
        for step in steps:
            self.brick("render", *view, "--method", "slices", "--step", step, *options, "-o", "a.exr")
            errors.append(self.json("compare", "a.exr", "exact.exr")["rmse"])
        print(" ".join(options), ["%.3g" % error for error in errors])
        return errors

    @cli.needs_ct
    @cli.needs_gl
    def test_own_field(self):
        """Values interpolated: samples in the middle of pieces, so the error falls by four as the step halves. Voxels
        classified before: opacity of a slice is interpolated and not extinction, which differ by the square of a slice's
        depth, a step's share of the sum: by two."""
        self.ct()
        for emission in ["scaled", "independent"]:
            view = ["ct.brick", *BONE, "--emission", emission]
            post = self.errors(view, [], ["1", "0.5", "0.25", "0.125"], "--termination", "0")
            pre = self.errors(view, ["--field", "preclassified"], ["1", "0.5", "0.25", "0.125"], "--termination", "0",
                              "--classification", "pre")
            for coarse, fine in zip(post, post[1:]):
                self.assertGreater(coarse / fine, 3)
                self.assertLess(coarse / fine, 5.5)
            for coarse, fine in zip(pre, pre[1:]):
                self.assertGreater(coarse / fine, 1.6)
                self.assertLess(coarse / fine, 3)

    @cli.needs_ct
    @cli.needs_gl
    def test_preintegrated(self):
        """As rays do: the error falls by four as the step halves, and by 1.5 orders where it is lit; and it is theirs."""
        self.ct()
        for mode, least in [("dvr", 3), ("shaded", 2)]:
            view = ["ct.brick", *BONE, "--mode", mode, "--classification", "preintegrated", "--termination", "0"]
            exact = ["ct.brick", *BONE, "--mode", mode]
            self.brick("render", *exact, "--method", "exact", "-o", "exact.exr")
            errors = {method: [] for method in ["raycast", "slices"]}
            for step in ["1", "0.5", "0.25", "0.125"]:
                for method in errors:
                    self.brick("render", *view, "--method", method, "--step", step, "-o", "a.exr")
                    errors[method].append(self.json("compare", "a.exr", "exact.exr")["rmse"])
            print(mode, errors)
            for coarse, fine in zip(errors["slices"], errors["slices"][1:]):
                self.assertGreater(coarse / fine, least)
            for slices, rays in zip(errors["slices"], errors["raycast"]):
                self.assertLess(slices, 1.25 * rays)

    @cli.needs_ct
    @cli.needs_gl
    def test_bits(self):
        """Rounded colours and pictures are as far off as the roundings of the slices on a ray together, and are off."""
        self.ct()
        view = ["render", "ct.brick", *BONE, "--method", "slices", "--termination", "0", "--planes", "300",
                "--classification", "pre"]
        self.brick(*view, "-o", "32.exr")
        for bits, unit in [("8", 1 / 255), ("16", 1 / 65535)]:
            self.brick(*view, "--classified-bits", bits, "-o", "a.exr")
            error = self.json("compare", "a.exr", "32.exr")["max_abs"]
            print("textures of", bits, error)
            self.assertLess(error, 300 * unit)  # half a unit each of colour and opacity
            self.assertGreater(error, 0.5 * unit)
        for bits, unit in [("8", 1 / 255), ("16f", 2 ** -11)]:
            self.brick(*view, "--framebuffer", bits, "-o", "a.exr")
            error = self.json("compare", "a.exr", "32.exr")["max_abs"]
            print("framebuffers of", bits, error)
            self.assertLess(error, 300 * unit)
            self.assertGreater(error, 0.5 * unit)

    @cli.needs_ct
    @cli.needs_gl
    def test_a_tenth_of_the_bricks(self):
        """Batches: the same bytes with a cache of a tenth of the active bricks, colours included."""
        self.ct()
        for options in [[], ["--classification", "pre"], ["--order", "back"], ["--mode", "shaded"], ["--mode", "mip"],
                        ["--classification", "preintegrated"], ["--classification", "preintegrated", "--mode", "shaded"]]:
            view = ["render", "ct.brick", *BONE, "--method", "slices", "--step", "1", *options]
            whole = json.loads(self.brick(*view, "-o", "whole.exr", "--json"))
            share = whole["bricks_active"] // 10
            brick = whole["gpu_cache_peak_bytes"] // whole["bricks_loaded"]
            part = json.loads(self.brick(*view, "-o", "part.exr", "--json", "--gpu-cache", str(share * brick),
                                         "--host-cache", "2M"))
            with self.subTest(options=options):
                self.assertTrue(self.read("whole.exr") == self.read("part.exr"))
                self.assertLessEqual(part["gpu_cache_bytes"], share * brick)
                self.assertGreater(part["passes"], whole["passes"])

    @cli.needs_gl
    def test_marschner_lobb(self):
        self.brick("synth", "marschner-lobb", "--size", "64x64x64", "-o", "ml.brick", "--quiet")
        view = ["ml.brick", "--tf", "gray", "--size", "96x96", "--camera", "30,40", "--ortho", "80", "--quiet"]
        post = self.errors(view, [], ["0.5", "0.25", "0.125"], "--termination", "0")
        pre = self.errors(view, ["--field", "preclassified"], ["0.5", "0.25", "0.125"], "--termination", "0",
                          "--classification", "pre")
        for coarse, fine in zip(post, post[1:]):
            self.assertGreater(coarse / fine, 3)
        for coarse, fine in zip(pre, pre[1:]):
            self.assertGreater(coarse / fine, 1.6)

    @cli.needs_gl
    def test_planes(self):
        """64 voxels a side, seen straight on: 110 planes, as in the paper (section 2.2.4)."""
        self.brick("synth", "ramp", "--size", "64x64x64", "-o", "c.brick", "--quiet")
        view = ["render", "c.brick", "--method", "slices", "--size", "32x32", "--quiet"]
        self.brick(*view, "-o", "a.exr")
        self.brick(*view, "--planes", "110", "-o", "b.exr")
        self.brick(*view, "--planes", "111", "-o", "c.exr")
        self.assertTrue(self.read("a.exr") == self.read("b.exr"))
        self.assertFalse(self.read("a.exr") == self.read("c.exr"))

    @cli.needs_gl
    def test_refusals(self):
        self.brick("synth", "constant", "--size", "8x8x8", "-o", "c.brick", "--quiet")
        view = ["render", "c.brick", "-o", "a.exr", "--method", "slices"]
        self.fails(1, "isosurfaces", *view, "--mode", "iso", "--iso", "1")
        self.fails(1, "does not hold one brick", *view, "--classification", "pre", "--gpu-cache", "20K")
        self.fails(2, "--planes", "render", "c.brick", "-o", "a.exr", "--planes", "10")
        for options in [["--setup", "geometry"], ["--offset", "interleaved"], ["--budget", "1"]]:
            self.fails(2, "raycast or multipass", *view, *options)
        self.fails(2, "exclude", *view, "--planes", "10", "--step", "1")
        self.fails(2, "--classification pre", *view, "--classified-bits", "8")
        self.fails(2, "--classification pre", *view, "--classification", "pre", "--mode", "shaded")
        self.fails(2, "--termination", *view, "--order", "back", "--termination", "0.1")
        slabs = [*view, "--classification", "preintegrated"]
        self.fails(1, "scaled by extinction", *slabs, "--emission", "independent")
        self.fails(1, "at least 14 planes here, not 13", *slabs, "--planes", "13", "--ortho", "10")
        self.fails(1, "up to 1 voxel edges here, not 1.1", *slabs, "--step", "1.1", "--ortho", "10")
        self.fails(1, "up to 0.9.* voxel edges here, not 1", *slabs, "--step", "1")
        self.assertFalse(os.path.exists(self.path("a.exr")))
        self.brick(*slabs, "--quiet")


cli.main()

"""Projected cells from outside: against the exact integral of their field on the real CT and on Marschner-Lobb, from a cache of
a tenth of what is visible, and what they refuse."""

import cli

NEAR = ["--camera", "20,10", "--size", "96x96", "--quiet"]
VIEW = ["--ortho", "240", *NEAR]


@cli.needs_gl
class Cells(cli.Case):
    def errors(self, volume, view, integrations):
        """Of each integration, to the exact picture of the field on tetrahedra."""
        self.brick("render", volume, *view, "--method", "exact", "--field", "tetrahedra", "-o", "ruler.exr")
        out = {}
        for how in integrations:
            self.brick("render", volume, *view, "--method", "cells", "--cells-integration", how, "-o", how + ".exr")
            out[how] = self.json("compare", how + ".exr", "ruler.exr")
            print(volume, how, "max_abs %.3g rmse %.3g" % (out[how]["max_abs"], out[how]["rmse"]))
        return out

    @cli.needs_ct
    def test_real_ct(self):
        """A ray within 1/256 pixel of a tetrahedron's outline may count one that it misses, or not one that it meets, by its
        length there: some 0.01 mm at an extinction of at most 2 a mm. Such rays are some percent; all else is rounding."""
        self.ct()
        for tf, integrations in [("ct-bone", ["prefix", "exact", "psi", "exp", "average", "scalar"]), ("ct-skin", ["prefix"])]:
            errors = self.errors("ct.brick", ["--tf", tf, *VIEW], integrations)
            for how in ["prefix", "exact"]:
                if how in errors:  # prefix: of the colours' differences in a tetrahedron at most depth^3 / 56 more
                    self.assertLess(errors[how]["max_abs"], 2e-2)
                    self.assertLess(errors[how]["rmse"], 2e-4)
            for how in integrations[2:]:  # linear from end to end, whatever the transfer function does between
                self.assertGreater(errors[how]["rmse"], 10 * errors["prefix"]["rmse"])
                self.assertLess(errors[how]["rmse"], 0.02)

    @cli.needs_ct
    def test_real_ct_in_perspective(self):
        """Nothing but rounding: 620 cells on a ray at most, each with 2^-24; in the mean square that adds up as noise does."""
        self.ct()
        inside = ["--eye", "120,-120,60", "--look", "10,-200,100", "--fov", "80", "--size", "96x96", "--quiet"]
        box = ["--clip-box", "30,170,-200,-60,20,120"]
        for view in [NEAR, inside, NEAR + box, NEAR + ["--level", "1"]]:
            errors = self.errors("ct.brick", ["--tf", "ct-bone", *view], ["prefix", "exact", "psi"])
            self.assertLess(errors["exact"]["max_abs"], 625 * 2 ** -24)
            self.assertLess(errors["exact"]["rmse"], 25 * 2 ** -24)
            self.assertLess(errors["prefix"]["max_abs"], 2e-2)  # colour: at most depth^3 / 56 a tetrahedron
            self.assertLess(errors["prefix"]["rmse"], 5e-4)
            self.assertGreater(errors["psi"]["rmse"], 3 * errors["prefix"]["rmse"])
        self.write("path.json", b'[{"azimuth": 20, "elevation": 10}, {"azimuth": 50}]')
        self.brick("render", "ct.brick", "--tf", "ct-bone", "--method", "cells", *NEAR[2:], "--path", "path.json", "-o", "p.exr")
        self.brick("render", "ct.brick", "--tf", "ct-bone", "--method", "cells", *NEAR, "-o", "near.exr")
        self.assertEqual(self.read("p-0000.exr"), self.read("near.exr"))

    def test_marschner_lobb(self):
        self.brick("synth", "marschner-lobb", "--size", "48x48x48", "-o", "ml.brick", "--quiet")
        # Of these all but the first see faces of tetrahedra almost edge on.
        for camera in ["31.7,22.3", "30.1,20", "45.1,35.2", "0.1,0.2"]:
            view = ["--tf", "gray", "--camera", camera, "--ortho", "70", "--size", "96x96", "--quiet"]
            errors = self.errors("ml.brick", view, ["prefix", "psi"])
            for how in ["prefix", "psi"]:  # extinction up to 0.22 a voxel; one straight line, so psi lacks little
                self.assertLess(errors[how]["max_abs"], 1e-2)
                self.assertLess(errors[how]["rmse"], 1e-4)
            errors = self.errors("ml.brick", view[:4] + ["--size", "96x96", "--quiet"], ["prefix", "exact", "psi"])
            for how in ["prefix", "exact"]:  # one straight line: what prefix leaves out is below what is rounded
                self.assertLess(errors[how]["max_abs"], 150 * 2 ** -24)
            self.assertLess(errors["psi"]["max_abs"], 1e-3)

    @cli.needs_ct
    def test_a_tenth_of_the_active_set(self):
        self.ct()
        for view in [VIEW, NEAR]:
            self.a_tenth(["ct.brick", "--tf", "ct-bone", *view, "--method", "cells"])

    def a_tenth(self, view):
        all_of_it = self.json("render", *view, "-o", "all.exr")
        self.assertEqual(all_of_it["passes"], 1)
        self.assertLess(all_of_it["samples"], all_of_it["tetrahedra"] / 10)
        self.assertGreater(all_of_it["seconds_draw"], 0)
        limit = all_of_it["bricks_active"] // 10 * 36 ** 3 * 2
        few = self.json("render", *view, "-o", "few.exr", "--gpu-cache", str(limit), "--host-cache", str(limit))
        self.assertEqual(self.read("all.exr"), self.read("few.exr"))
        self.assertGreaterEqual(few["passes"], 10)
        self.assertLessEqual(few["gpu_cache_bytes"], limit)
        self.assertLessEqual(few["bricks_loaded"], few["bricks_active"])  # each once: the order is known beforehand

    @cli.needs_ct
    def test_clip_box(self):
        self.ct()
        box = ["1,0,0,90.2", "-1,0,0,-150", "0,1,0,-200", "0,-1,0,60.7", "0,0,1,20", "0,0,-1,-120"]
        view = ["--clip=" + plane for plane in box] + ["--tf", "ct-bone", *VIEW]
        error = self.errors("ct.brick", view, ["prefix"])["prefix"]
        self.assertLess(error["max_abs"], 2e-2)
        self.assertLess(error["rmse"], 5e-4)

    def test_opacity(self):
        """Extinction times 3: what gets through is raised to the third power."""
        self.brick("synth", "marschner-lobb", "--size", "20x20x20", "-o", "ml.brick", "--quiet")
        view = ["ml.brick", "--tf", "gray", "--ortho", "30", "--size", "9x9", "--quiet"]
        for method in [["cells"], ["exact"], ["raycast", "--termination", "0"]]:
            through = []
            for opacity in ["1", "3"]:
                self.brick("render", *view, "--method", *method, "--opacity", opacity, "-o", "a.exr")
                through.append(1 - self.centre_alpha("a.exr"))
            self.assertGreater(through[0], 0.01)
            self.assertAlmostEqual(through[1], through[0] ** 3, delta=1e-5)
        self.fails(2, "opacity", "render", "ml.brick", "-o", "b.exr", "--opacity", "0")

    def centre_alpha(self, name):
        """Of a picture of 9 x 9: the largest difference to one that is empty there is its alpha, colours being below it."""
        self.brick("render", "ml.brick", "--tf", "gray", "--ortho", "1e9", "--size", "9x9", "--quiet", "--method", "exact", "-o",
                   "empty.exr", "--eye", "1e9,0,0", "--look", "2e9,0,0")
        return self.json("compare", name, "empty.exr")["max_abs"]

    def test_refusals(self):
        self.brick("synth", "shells", "--size", "20x20x20", "--type", "u8", "-o", "a.brick", "--quiet")
        cells = ["render", "a.brick", "-o", "b.exr", "--method", "cells"]
        for options, mention in [(["--mode", "shaded"], "dvr"),
                                 (["--ortho", "9", "--step", "1"], "--step"),
                                 (["--ortho", "9", "--classification", "post"], "--classification"), (["--ortho", "9", "--termination", "0"], "--term"),
                                 (["--ortho", "9", "--cells-integration", "fine"], "integration")]:
            self.fails(2, mention, *cells, *options)
        self.fails(2, "cells-integration", "render", "a.brick", "-o", "b.exr", "--cells-integration", "psi")
        points = ", ".join("[%g, 1, 1, 1, %g]" % (i / 40, 1e-3 * (i % 2)) for i in range(4000))
        self.write("tf.json", b'{"unit": 1.0, "values": "physical", "points": [%s]}' % points.encode())
        for view in [["--ortho", "30"], []]:
            self.fails(1, "prefix", *cells, *view, "--tf", "./tf.json", "--cells-integration", "exact")


cli.main()

"""The measurements: what they leave is complete and true where truth is known. Seconds are not judged."""

import csv
import json
import os
import shutil
import subprocess

import cli


@cli.needs_gl
class Accuracy(cli.Case):
    def rows(self, *options):
        self.brick("synth", "marschner-lobb", "--size", "32x32x32", "--type", "f32", "-o", "ml.brick", "--quiet")
        text = self.brick("bench", "accuracy", "ml.brick", "-o", "out", "--size", "48x48", "--frames", "1", *options)
        with open(self.path("out/accuracy.csv"), newline="") as file:
            return text, list(csv.DictReader(file))

    def test_rows(self):
        text, rows = self.rows("--steps", "1,0.5,0.25,0.125")
        self.assertIn("order", text)
        raycast = [r for r in rows if r["variant"] == "raycast"]
        self.assertEqual([float(r["step"]) for r in raycast], [1, 0.5, 0.25, 0.125])
        # Midpoint samples of a piecewise smooth field have second order, give or take where samples meet the kinks at
        # cells' faces: half an order over three halvings.
        self.assertGreater(float(raycast[0]["order"]), 1.5)
        self.assertLess(float(raycast[0]["order"]), 2.5)

    def test_pareto(self):
        _, rows = self.rows("--steps", "2,0.5")
        values = [(float(r["seconds"]), float(r["rmse_trilinear"]), r["pareto"] == "1") for r in rows]
        for s, e, front in values:
            beaten = any(s2 <= s and e2 <= e and (s2 < s or e2 < e) for s2, e2, _ in values)
            self.assertEqual(front, not beaten)

    def test_plots(self):
        self.rows("--steps", "1")
        self.assertTrue(os.path.exists(self.path("out/accuracy.gp")))
        if shutil.which("gnuplot"):
            self.assertIn(b"<svg", self.read("out/accuracy.svg"))
            self.assertTrue(self.read("out/accuracy.png").startswith(b"\x89PNG"))

    def test_folder(self):
        self.brick("synth", "constant", "--size", "8x8x8", "-o", "c.brick", "--quiet")
        self.write("taken", b"")
        self.fails(1, "taken: cannot make this folder", "bench", "accuracy", "c.brick", "-o", "taken")
        self.fails(2, "no output", "bench", "accuracy", "c.brick")
        self.fails(2, "not above 0", "bench", "accuracy", "c.brick", "-o", "x", "--steps", "1,0")


class View(cli.Case):
    def test_view(self):
        """Every measurement of pictures has these options from one place; this one needs no OpenGL."""
        self.brick("synth", "ramp", "--size", "16x16x16", "--type", "u8", "-o", "r.brick", "--quiet")
        for options, iso in (["--iso", "100"], 100), ([], 127.5):
            said = json.loads(self.brick("bench", "isotrace", "r.brick", "--size", "24x16", "--frames", "1", "--json",
                                         *options))
            self.assertEqual([said["width"], said["height"], said["iso"]], [24, 16, iso])


def has_vtk():
    """VTK for Debian's Python, which brick asks unless told otherwise, and a display to draw on."""
    return shutil.which("xvfb-run") and not subprocess.run(
        ["/usr/bin/python3", "-c", "import vtk"], capture_output=True).returncode


@cli.needs_gl
@cli.needs_png
class Peers(cli.Case):
    def make(self):
        self.brick("synth", "ct", "--size", "64x56x48", "--type", "i16", "-o", "ct.brick", "--quiet")

    def test_same_picture(self):
        """Both sides draw the same thing: where VTK is as good as its 8 bits allow, so is the difference."""
        if not has_vtk():
            self.skipTest("VTK or xvfb is not installed")
        self.make()
        self.brick("bench", "peers", "ct.brick", "-o", "out", "--size", "96x96", "--frames", "1", "--step", "0.25",
                   "--camera", "20,10", "--iso", "300", "--tf", "ct-bone")
        with open(self.path("out/peers.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([r["mode"] for r in rows], ["dvr"] * 6 + ["shaded"] * 6 + ["iso"] * 6)
        dvr = {r["way"]: float(r["rmse"]) for r in rows if r["mode"] == "dvr"}
        # Far below what a picture that is mirrored or moved by a pixel would give: the bones are as thin as pixels.
        self.assertLess(dvr["VTK GPU mapper"], 0.01)
        self.assertLess(dvr["raycast"], 1e-3)
        names = os.listdir(self.path("out"))
        self.assertIn("iso, VTK flying edges, mesh.png", names)
        self.assertNotIn("volume.raw", names)

    def test_no_python(self):
        self.make()
        self.brick("synth", "constant", "--size", "8x8x8", "-o", "c.brick", "--quiet")
        os.mkdir(self.path("out"))
        line = self.run_brick("bench", "peers", "c.brick", "-o", "out", "--size", "8x8", "--python", "/nowhere/python3")
        self.assertEqual(line.returncode, 1)
        self.assertIn("brick bench peers: ", line.stderr)
        self.assertEqual(os.listdir(self.path("out")), [])


if __name__ == "__main__":
    cli.main()

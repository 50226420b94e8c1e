"""Meshes and clip planes through the program: on the real CT against the exact method, from files of both formats, and what is
wrong with them."""

import math
import struct

import cli

NOSE = (122, -190, 80)  # of the CT, in mm: a sphere there is half in the face's bones


def sphere(centre, radius, n):
    vertices, faces = [], []
    for i in range(n + 1):
        for j in range(2 * n):
            a, b = math.pi * i / n, math.pi * j / n
            unit = (math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a))
            vertices.append(tuple(c + radius * u for c, u in zip(centre, unit)))
    for i in range(n):
        for j in range(2 * n):
            p, q = i * 2 * n + j, i * 2 * n + (j + 1) % (2 * n)
            faces += [(p + 2 * n, q + 2 * n, q)] * (i < n - 1) + [(p, p + 2 * n, q)] * (i > 0)
    return vertices, faces


def ply(vertices, faces):
    header = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n%selement face %d\n%send_header\n" % (
        len(vertices), "".join("property double %s\n" % a for a in "xyz"), len(faces),
        "property list uchar int vertex_indices\n")
    return header.encode() + b"".join(struct.pack("<3d", *v) for v in vertices) + b"".join(
        struct.pack("<B3i", 3, *f) for f in faces)


def obj(vertices, faces):
    return "".join("v %r %r %r\n" % v for v in vertices).encode() + b"".join(
        b"f %d %d %d\n" % tuple(k + 1 for k in f) for f in faces)


@cli.needs_exr
class Meshes(cli.Case):
    def small(self):
        self.write("small.raw", bytes(i % 251 for i in range(16 ** 3)))
        self.brick("convert", "small.raw", "--size", "16x16x16", "--type", "u8", "-o", "small.brick", "--quiet")
        self.write("s.ply", ply(*sphere((7, 8, 6), 5, 8)))

    @cli.needs_ct
    @cli.needs_gl
    def test_six_sides(self):
        """Flat colours, so that a pixel is the bone's, the mesh's or nobody's. The two methods may differ where the mesh's
        outline or a grazed surface is finer than a rasteriser or a step sees."""
        self.ct()
        self.write("s.ply", ply(*sphere(NOSE, 30, 48)))
        flat = ["--ambient", "1", "--diffuse", "0", "--specular", "0", "--mesh", "s.ply", "--mesh-color", "0,0,1"]
        for side in ["0,0", "90,0", "180,0", "270,0", "0,90", "0,-90"]:
            view = ["ct.brick", "--mode", "iso", "--iso", "300", "--camera", side, "--ortho", "250", "--size", "100x100", *flat,
                    "--quiet"]
            self.brick("render", *view, "--step", "0.25", "-o", "a.exr")
            self.brick("render", *view, "--method", "exact", "-o", "exact.exr")
            error = self.json("compare", "a.exr", "exact.exr")
            print("from %s: %d of 10000 pixels differ" % (side, error["pixels_differing"]))
            with self.subTest(side=side):
                self.assertLessEqual(error["pixels_differing"], 10)

    @cli.needs_ct
    def test_isotrace_has_the_exact_picture(self):
        """Both solve for where a ray meets a surface and a triangle; what is left is float32's rounding."""
        self.ct()
        self.write("s.ply", ply(*sphere(NOSE, 30, 48)))
        for side in ["0,0", "250,40"]:
            view = ["ct.brick", "--mode", "iso", "--iso", "300", "--camera", side, "--size", "100x100", "--mesh", "s.ply",
                    "--clip", "-1,0.3,0,-170", "--quiet"]
            self.brick("render", *view, "--method", "isotrace", "-o", "a.exr")
            self.brick("render", *view, "--method", "exact", "-o", "exact.exr")
            self.assertLess(self.json("compare", "a.exr", "exact.exr")["max_abs"], 2e-6)
        self.brick("render", *view, "--method", "isotrace", "--shadows", "-o", "shadows.exr")
        self.assertGreater(self.json("compare", "a.exr", "shadows.exr")["max_abs"], 0.1)

    @cli.needs_ct
    def test_matter_around_a_mesh(self):
        """Matter before the mesh is summed up to it: the error falls as the square of the step."""
        self.ct()
        self.write("s.ply", ply(*sphere(NOSE, 30, 48)))
        view = ["ct.brick", "--tf", "ct-bone", "--camera", "60,20", "--size", "80x80", "--mesh", "s.ply", "--clip",
                "-1,0.3,0,-170", "--ambient", "1", "--diffuse", "0", "--specular", "0", "--quiet"]
        self.brick("render", *view, "--method", "exact", "-o", "exact.exr")
        for context in ["cpu"] + ["egl"] * cli.HAS_EGL + ["osmesa"] * cli.HAS_OSMESA:
            errors = []
            for step in ["0.5", "0.25", "0.125"]:
                self.brick("render", *view, "--step", step, "--termination", "0", "--context", context, "-o", "a.exr")
                errors.append(self.json("compare", "a.exr", "exact.exr"))
                print("%s, step %s: rmse %.3g, max_abs %.3g" % (context, step, errors[-1]["rmse"], errors[-1]["max_abs"]))
            for coarse, fine in zip(errors, errors[1:]):
                self.assertGreater(coarse["rmse"] / fine["rmse"], 3)

    @cli.needs_gl
    def test_box_is_six_planes(self):
        self.small()
        view = ["small.brick", "--size", "64x64", "--camera", "30,20", "--quiet"]
        planes = ["1,0,0,2", "-1,0,0,-11.5", "0,1,0,3", "0,-1,0,-12", "0,0,1,1", "0,0,-1,-9"]
        self.brick("render", *view, "-o", "whole.exr")
        self.brick("render", *view, "-o", "box.exr", "--clip-box", "2,11.5,3,12,1,9")
        self.brick("render", *view, "-o", "planes.exr", *[word for plane in planes for word in ("--clip", plane)])
        self.brick("render", *view, "-o", "exact.exr", "--clip-box", "2,11.5,3,12,1,9", "--method", "exact")
        self.assertTrue(self.read("box.exr") == self.read("planes.exr"))
        self.assertFalse(self.read("box.exr") == self.read("whole.exr"))
        self.assertLess(self.json("compare", "box.exr", "exact.exr")["rmse"],
                        self.json("compare", "whole.exr", "exact.exr")["rmse"] / 20)
        self.brick("render", *view, "-o", "none.exr", "--clip-box", "200,201,3,12,1,9")
        self.assertEqual(self.json("compare", "none.exr", "exact.exr")["covered_only_a"], 0)

    def test_formats(self):
        """The same mesh from both formats is the same picture."""
        self.small()
        view = ["small.brick", "--size", "48x48", "--method", "exact", "--quiet"]
        self.brick("render", *view, "--mesh", "s.ply", "-o", "ply.exr")
        self.write("s.obj", obj(*sphere((7, 8, 6), 5, 8)))
        if cli.HAS_OBJ:
            self.brick("render", *view, "--mesh", "s.obj", "-o", "obj.exr")
            self.assertTrue(self.read("ply.exr") == self.read("obj.exr"))
        else:
            self.fails(1, "libtinyobjloader-dev", "render", *view, "--mesh", "s.obj", "-o", "a.exr")

    def test_bad_meshes(self):
        self.small()
        render = ["render", "small.brick", "--method", "exact", "-o", "a.exr", "--mesh"]
        good = self.read("s.ply")
        for name, data, says in [("cut.ply", good[:-1], "cut.ply: the file ends"), ("head.ply", good[:100], "head.ply: "),
                                 ("empty.ply", b"", "empty.ply"), ("noise.ply", bytes(range(256)), "noise.ply: line 1"),
                                 ("s.stl", good, "must end in"),
                                 ("index.ply", good[:-4] + b"\xff\xff\xff\x7f", "index.ply: .*vertex")]:
            self.write(name, data)
            self.fails(1, says, *render, name)
        self.fails(1, "missing.ply", *render, "missing.ply")


cli.main()

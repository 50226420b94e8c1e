"""The page of info --report: well formed, on its own, and its pictures, maps, curves and tables say what is so."""

import base64
import html.parser
import math
import os
import re

import cli
import png

VOID = {"meta", "img", "path", "rect", "image", "br"}


class Page(html.parser.HTMLParser):
    """Every element with its attributes and text; complains about tags that are not closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements = [], []
        self.feed(text)
        self.close()
        if self.open:
            raise ValueError("not closed: %s" % self.open[-1]["tag"])

    def handle_starttag(self, tag, attrs):
        within = [e["id"] for e in self.open if e.get("id")]
        element = {**dict(attrs), "tag": tag, "text": "", "within": within}
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if not self.open or self.open[-1]["tag"] != tag:
            raise ValueError("closes %s, which is not open" % tag)
        self.open.pop()

    def handle_data(self, data):
        for element in self.open:
            element["text"] += data

    def find(self, tag, within=None, style=None):
        return [e for e in self.elements if e["tag"] == tag and (within is None or within in e["within"])
                and (style is None or style in (e.get("class") or "").split())]

    def pictures(self, within):
        return [png.decode(base64.b64decode((e.get("src") or e["href"]).split(",", 1)[1], validate=True))
                for e in self.find("img", within) + self.find("image", within)]

    def table(self, name):
        cells, rows = self.find("td", name), len(self.find("tr", name)) - 1
        columns = len(cells) // rows
        return [[c["text"].strip() for c in cells[r * columns:(r + 1) * columns]] for r in range(rows)]

    def facts(self):
        return dict(zip((e["text"] for e in self.find("dt")), (e["text"] for e in self.find("dd"))))


def number(text):
    return float(text.replace(",", ""))


def curve(page, figure, style):
    """Points of a chart's path, back in the units of its axes."""
    svg = page.find("svg", figure)[0]
    left, top, width, height = map(float, svg["data-plot"].split())
    (x0, x1), (y0, y1) = (map(float, svg[axis].split()) for axis in ["data-x", "data-y"])
    points = re.findall(r"[ML]([\d.]+) ([\d.]+)", page.find("path", figure, style)[0]["d"])
    return [(x0 + (float(x) - left) / width * (x1 - x0), y1 - (float(y) - top) / height * (y1 - y0)) for x, y in points]


@cli.needs_png
class Report(cli.Case):
    def convert(self, kind, values, dims, *options):
        self.write("a.raw", cli.pack(kind, values))
        self.brick("convert", "a.raw", "--size", "x".join(map(str, dims)), "--type", kind, "-o", "a.brick", "--quiet",
                   *options)

    def report(self, name="a.brick", *options):
        self.brick("info", name, "--report", "a.html", *options)
        text = self.read("a.html").decode("utf-8")
        page = Page(text)
        # On its own: every reference is data, and nothing runs.
        for element in page.elements:
            self.assertNotIn(element["tag"], {"script", "link", "iframe", "object", "embed", "base"})
            for name, value in element.items():
                if name in {"src", "href", "srcset", "action", "data", "poster"}:
                    self.assertTrue(value.startswith("data:image/png;base64,"), value[:80])
                self.assertFalse(name.startswith("on"), name)
        self.assertNotRegex(text, r"(?i)https?:|file:|url\(|@import")
        self.assertNotIn(self.folder, text)
        return page

    def test_numbers(self):
        """Tables and curves against --json, which test_info.py holds against the voxels."""
        self.brick("synth", "ct", "--size", "90x70x60", "-o", "a.brick", "--brick", "16", "--quiet")
        page, info = self.report("a.brick", "--tf", "ct-bone"), self.json("info", "a.brick", "--bricks", "--tf", "ct-bone")

        facts = page.facts()
        self.assertTrue(facts["Bricks"].startswith("{:,}".format(info["bricks"])), facts)
        self.assertTrue(facts["Constant"].startswith("%.1f%%" % (100 * info["constant_share"])), facts)
        self.assertTrue(facts["Visible"].startswith("%.1f%%" % (100 * info["active_share"])), facts)
        low, high = (number(part) for part in re.match(r"(\S+) … ([\d,.]+)", facts["Range"]).groups())
        self.assertEqual([low, high], info["range"])

        levels = page.table("levels")
        self.assertEqual(len(levels), len(info["levels"]))
        for row, level in zip(levels, info["levels"]):
            self.assertEqual([number(n) for n in row[1].split("×")], level["dims"])
            self.assertEqual([number(row[i]) for i in (2, 4, 5)],
                             [level["bricks"], level["voxel_bytes"], level["payload_bytes"]])
            self.assertAlmostEqual(float(row[6]), level["ratio"], delta=0.005)

        heaviest = sorted(range(info["bricks"]), key=lambda i: (-info["brick_list"][i]["bytes"], i))[:20]
        rows = page.table("heaviest")
        self.assertEqual([number(row[0]) for row in rows], heaviest)
        for row, brick in zip(rows, (info["brick_list"][i] for i in heaviest)):
            self.assertEqual([number(row[1]), [number(n) for n in row[2].split(", ")], number(row[4])],
                             [brick["level"], brick["at"], brick["bytes"]])

        # Two decimals of a plot 268 pixels high: 0.004% of the axis.
        for style, name in [("crossed", "bricks_crossed"), ("above", "bricks_above"), ("voxels", "voxels_above")]:
            points = curve(page, "active", style)
            self.assertEqual(len(points), len(info["active"]["values"]))
            for (x, y), value, share in zip(points, info["active"]["values"], info["active"][name]):
                self.assertAlmostEqual(x, value, delta=1e-4 * (high - low))
                self.assertAlmostEqual(y, 100 * share, delta=0.01)

        svg = page.find("svg", "histogram")[0]
        (_, top, _, height), ends = (list(map(float, svg[name].split())) for name in ["data-plot", "data-y"])
        bars = [float(y) for y in re.findall(r"V([\d.]+)H", page.find("path", "histogram", "bars")[0]["d"])]
        self.assertEqual(len(bars), len(info["histogram"]))
        for y, share in zip(bars, info["histogram"]):
            count = ends[0] * (ends[1] / ends[0]) ** (1 - (y - top) / height)
            self.assertAlmostEqual(math.log(count), math.log(max(ends[0], share * info["voxels_finite"])), delta=1e-3)

        counts = [float(y) for y in re.findall(r"V([\d.]+)H", page.find("path", "sizes", "bars")[0]["d"])]
        self.assertEqual(len(counts), len(info["brick_bytes"]["by_share_of_decoded"]))

        # Cells of the range chart: one for every place that some brick's range falls into.
        width, height, _, samples = page.pictures("ranges")[0]
        cells = {(min(width - 1, int((lo - low) / (high - low) * width)),
                  height - 1 - min(height - 1, int((hi - low) / (high - low) * height)))
                 for lo, hi in (b["range"] for b in info["brick_list"] if b["level"] == 0)}
        self.assertEqual({(i % width, i // width) for i in range(width * height) if samples[4 * i + 3]}, cells)

    def check_picture(self, picture, dims, voxel, window):
        """voxel(column, row): the physical value that belongs there."""
        self.assertEqual(picture[:3], (*dims, 1))
        for row in range(dims[1]):
            for column in range(dims[0]):
                t = (voxel(column, row) - window[0]) / (window[1] - window[0])
                self.assertAlmostEqual(picture[3][row * dims[0] + column], 255 * min(1, max(0, t)), delta=0.51)

    def test_pictures(self):
        """Slices, their window and how they hang: right and front on the left, front and head on top."""
        nx, ny, nz = 19, 13, 10
        values = [(7 * x + 31 * y + 57 * z) % 1000 for z in range(nz) for y in range(ny) for x in range(nx)]
        at = lambda x, y, z: values[(z * ny + y) * nx + x]
        ranked = sorted(values)
        for axes, flips in [("LPS", (0, 0, 0)), ("RAI", (1, 1, 1))]:
            self.convert("i16", values, (nx, ny, nz), "--axes", axes, "--brick", "8")
            page = self.report()
            window = [number(n) for n in re.search(r"Black is ([-\d,.]+), white ([-\d,.]+) \(",
                                                   page.find("section")[0]["text"]).groups()]
            for got, share in zip(window, (0.005, 0.995)):
                self.assertAlmostEqual(got, ranked[int(share * len(ranked))], delta=ranked[-1] / 100)
            x = lambda i: nx - 1 - i if flips[0] else i
            y = lambda i: ny - 1 - i if flips[1] else i
            z = lambda i: i if flips[2] else nz - 1 - i
            sagittal, coronal, axial = page.pictures("slices")
            self.check_picture(sagittal, (ny, nz), lambda c, r: at(nx // 2, y(c), z(r)), window)
            self.check_picture(coronal, (nx, nz), lambda c, r: at(x(c), ny // 2, z(r)), window)
            self.check_picture(axial, (nx, ny), lambda c, r: at(x(c), y(r), nz // 2), window)
            self.assertEqual([h["text"] for h in page.find("h3", "slices")], ["Sagittal", "Coronal", "Axial"])
            self.assertEqual([b["text"] for b in page.find("b", "slices")], list("APSI" "RLSI" "RLAP"))

        # x of the file goes up, y to the right, z to the front: planes are named after what they are.
        self.convert("i16", values, (nx, ny, nz), "--axes", "SRA", "--brick", "8")
        page = self.report()
        axial, sagittal, coronal = page.pictures("slices")
        window = [number(n) for n in re.search(r"Black is ([-\d,.]+), white ([-\d,.]+) \(",
                                               page.find("section")[0]["text"]).groups()]
        self.assertEqual([h["text"] for h in page.find("h3", "slices")], ["Axial", "Sagittal", "Coronal"])
        self.check_picture(axial, (ny, nz), lambda c, r: at(nx // 2, ny - 1 - c, nz - 1 - r), window)
        self.check_picture(sagittal, (nz, nx), lambda c, r: at(nx - 1 - r, ny // 2, nz - 1 - c), window)
        self.check_picture(coronal, (ny, nx), lambda c, r: at(nx - 1 - r, ny - 1 - c, nz // 2), window)

    def test_maps(self):
        """Bricks of 1, 2, 4, ... values, equally many of each, have 0, 1, 2, ... bits a voxel."""
        for kind, scale, axes in [("u8", 1, "LPS"), ("i16", -100, "RPS"), ("f32", 0.25, "LPS")]:
            self.convert(kind, [scale * ((x + y + z) % 8 % 2 ** (x // 8)) for z in range(8) for y in range(8)
                                for x in range(32)], (32, 8, 8), "--brick", "8", "--macrocell", "4", "--axes",
                         axes)
            page, info = self.report(), self.json("info", "a.brick", "--bricks")
            stops = [tuple(bytes.fromhex(c)) for c in re.findall("#(......)", page.find("style")[0]["text"].split(".ramp")[1])]
            colour = lambda t: [a + (t * 4 - min(3, int(t * 4))) * (b - a)
                                for a, b in zip(stops[min(3, int(t * 4))], stops[min(3, int(t * 4)) + 1])]
            self.assertIn(" 3 bits a voxel", page.find("section")[1]["text"])
            for within, shares in [("entropy", [0, 1 / 3, 2 / 3, 1]), ("compressibility", None)]:
                width, height, channels, samples = page.pictures(within)[2]  # axial
                self.assertEqual((width, height, channels), (4, 1, 4))
                if axes[0] == "R":  # the brick with the highest x is on the left
                    samples = b"".join(samples[4 * i:4 * i + 4] for i in (3, 2, 1, 0))
                for brick in range(4):
                    constant = info["brick_list"][brick]["constant"]
                    self.assertEqual(samples[4 * brick + 3], 0 if constant else 255)
                    share = shares[brick] if shares else info["brick_list"][brick]["bytes"] / self.decoded(brick, kind)
                    for c in range(0 if constant else 3):
                        self.assertAlmostEqual(samples[4 * brick + c], colour(min(1, share))[c], delta=1.5)

    @staticmethod
    def decoded(brick, kind):
        return (12 ** 3 + 2 * 8) * {"u8": 1, "i16": 2, "f32": 4}[kind]

    def test_constant_bricks_are_left_out(self):
        self.convert("u8", [(x > 40) * ((x * y * z) % 7) for z in range(8) for y in range(8) for x in range(64)],
                     (64, 8, 8), "--brick", "8")
        page = self.report()
        opacity = [page.pictures("entropy")[2][3][4 * i + 3] for i in range(8)]
        constant = [b["constant"] for b in self.json("info", "a.brick", "--bricks")["brick_list"][:8]]
        self.assertEqual(opacity, [0 if c else 255 for c in constant])
        self.assertIn(True, constant)

    def test_equally_heavy(self):
        self.brick("synth", "checker", "--size", "32x32x32", "--type", "u8", "--brick", "8", "-o", "a.brick", "--quiet")
        page, bricks = self.report(), self.json("info", "a.brick", "--bricks")["brick_list"]
        order = sorted(range(len(bricks)), key=lambda i: (-bricks[i]["bytes"], i))
        self.assertEqual(bricks[order[0]]["bytes"], bricks[order[1]]["bytes"])
        self.assertEqual([number(row[0]) for row in page.table("heaviest")], order[:20])

    def test_large_volume(self):
        """Pictures of what is too large come from a coarser level, maps from some of the bricks."""
        self.brick("synth", "shells", "--size", "2600x40x9", "--type", "u8", "--brick", "8", "-o", "a.brick", "--quiet")
        page = self.report()
        _, coronal, axial = page.pictures("slices")
        # 2600 -> 1300 -> 650 on x, 40 -> 20 -> 10, 9 -> 5 -> 3.
        self.assertEqual((axial[:2], coronal[:2]), ((650, 10), (650, 3)))
        self.assertIn("level 2, 650 × 10 pixels", page.find("section")[0]["text"])
        self.assertEqual(page.pictures("entropy")[2][:2], (163, 3))  # 325 x 5 bricks, every second one
        self.assertIn("one brick in 2", page.find("section")[1]["text"])

    def test_beside_other_output(self):
        self.brick("synth", "ct", "--size", "40x40x40", "-o", "a.brick", "--quiet")
        self.assertEqual(self.brick("info", "a.brick", "--report", "a.html", "--threads", "1"), self.brick("info", "a.brick"))
        one = self.read("a.html")
        self.assertEqual(self.json("info", "a.brick", "--report", "a.html", "--threads", "3"), self.json("info", "a.brick"))
        self.assertEqual(self.read("a.html"), one)

    def test_odd_volumes(self):
        nan, inf = math.nan, math.inf
        self.convert("f32", [nan] * 1000, (10, 10, 10))
        page = self.report()
        self.assertIn("No voxel is finite", page.find("body")[0]["text"])
        self.assertEqual(page.find("svg"), [])
        self.convert("f32", [-1e38, 3e38, nan, inf, -inf] * 200, (10, 10, 10), "--slope", "-2", "--intercept", "1e9")
        self.report()
        self.convert("f32", [1e-30 * i for i in range(1000)], (1, 1, 1000), "--intercept", "1e12")
        self.report()
        self.convert("u8", [200] * 27, (3, 3, 3))
        page = self.report()
        self.assertEqual(set(page.pictures("slices")[0][3]), {128})
        self.assertEqual(page.table("levels")[0][6], "–")

    def test_names_are_not_trusted(self):
        name = "<script>alert('1')</script>&amp;\"\\\t\xe4".replace("/", "")
        self.brick("synth", "ramp", "--size", "9x9x9", "-o", name + ".brick", "--quiet")
        page = self.report(name + ".brick")
        self.assertEqual(page.find("h1")[0]["text"], name.replace("\t", " ") + ".brick")
        os.rename(os.fsencode(self.path(name + ".brick")), os.fsencode(self.path("")) + b"a\xff\xc0.brick")
        self.brick("info", os.fsdecode(b"a\xff\xc0.brick"), "--report", "a.html", "--json")
        self.assertEqual(Page(self.read("a.html").decode("utf-8")).find("h1")[0]["text"], "a\ufffd\ufffd.brick")

    def test_failures(self):
        self.brick("synth", "ct", "--size", "40x40x40", "-o", "a.brick", "--quiet")
        self.fails(2, r"\.html", "info", "a.brick", "--report", "a.brick")
        self.fails(1, "missing/a", "info", "a.brick", "--report", "missing/a.html")
        self.write("old.html", b"old")
        data = bytearray(self.read("a.brick"))
        first = next(b for b in self.json("info", "a.brick", "--bricks")["brick_list"] if not b["constant"])
        data[first["offset"] + first["bytes"] // 2] ^= 1
        self.write("a.brick", data)
        self.fails(1, "brick 0 .*checksum", "info", "a.brick", "--report", "old.html")
        self.assertEqual(self.read("old.html"), b"old")


@cli.unittest.skipIf(cli.HAS_PNG, "built with libpng")
class WithoutPng(cli.Case):
    def test_says_what_is_missing(self):
        self.brick("synth", "ct", "--size", "40x40x40", "-o", "a.brick", "--quiet")
        self.fails(1, "libpng", "info", "a.brick", "--report", "a.html")


cli.main()

"""What info says about a volume whose numbers are known, and what convert and render report as JSON."""

import math
import statistics

import cli

DIMS = (20, 18, 9)
COUNT = DIMS[0] * DIMS[1] * DIMS[2]


class Info(cli.Case):
    def test_known_volume(self):
        values = [(i * 37) % 1000 - 200 for i in range(COUNT)]
        self.write("a.raw", cli.pack("i16", values))
        report = self.json("convert", "a.raw", "--size", "20x18x9", "--type", "i16", "--spacing", "0.5,0.5,2", "--axes",
                           "RAS", "--slope", "-2", "--intercept", "10", "--brick", "8", "--macrocell", "4", "-o",
                           "a.brick", "--quiet")
        info = self.json("info", "a.brick", "--bricks", "--tf", "gray")
        physical = sorted(10 - 2 * v for v in values)

        self.assertEqual(report["input_bytes"], 2 * COUNT)
        self.assertEqual(report["output_bytes"], len(self.read("a.brick")))
        self.assertEqual(report["bricks"], info["bricks"])
        for field in ["bricks_empty", "seconds", "bytes_per_second", "peak_rss_bytes"]:
            self.assertIn(field, report)

        self.assertEqual(info["dims"], list(DIMS))
        self.assertEqual((info["type"], info["axes"], info["edge"]), ("i16", "RAS", 8))
        self.assertEqual(info["spacing_mm"], [0.5, 0.5, 2])
        self.assertEqual(info["affine"], [-0.5, 0, 0, 0, 0, -0.5, 0, 0, 0, 0, 2, 0])
        self.assertEqual(info["range"], [physical[0], physical[-1]])
        self.assertAlmostEqual(info["mean"], statistics.fmean(physical), places=9)
        self.assertAlmostEqual(info["standard_deviation"], statistics.pstdev(physical), places=6)
        self.assertEqual((info["voxels_finite"], info["voxels_nonfinite"]), (COUNT, 0))
        self.assertAlmostEqual(math.fsum(info["histogram"]), 1, places=12)
        shares = [info["percentiles"][q] for q in ["1", "5", "25", "50", "75", "95", "99"]]
        self.assertEqual(shares, sorted(shares))
        self.assertAlmostEqual(info["percentiles"]["50"], statistics.median(physical), delta=4)

        # z has four times the spacing of x and y: it is not halved until they have caught up.
        self.assertEqual([level["dims"] for level in info["levels"]][:2], [[20, 18, 9], [10, 9, 9]])
        self.assertEqual(info["levels"][0]["bricks_per_axis"], [3, 3, 2])
        self.assertTrue(all(n <= 8 for n in info["levels"][-1]["dims"]))
        self.assertEqual(sum(level["bricks"] for level in info["levels"]), info["bricks"])
        self.assertEqual(len(info["brick_list"]), info["bricks"])
        self.assertEqual(sum(b["bytes"] for b in info["brick_list"]), sum(l["payload_bytes"] for l in info["levels"]))
        self.assertLessEqual(info["bricks_active"], info["levels"][0]["bricks"])
        self.assertNotIn(self.folder, info["provenance"])

        text = self.brick("info", "a.brick", "--bricks", "--tf", "gray")
        for fact in ["20 x 18 x 9", "i16", "RAS", "histogram", "percentiles", "provenance", "visible"]:
            self.assertIn(fact, text)

    def test_constant_bricks(self):
        self.brick("synth", "constant", "--size", "40x40x40", "--type", "u8", "--value", "9", "-o", "a.brick", "--quiet")
        info = self.json("info", "a.brick")
        self.assertEqual(info["bricks_constant"], info["bricks"])
        self.assertEqual(info["range"], [9, 9])
        self.assertEqual(info["levels"][0]["payload_bytes"], 0)
        self.brick("info", "a.brick")


cli.main()

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

        # Integers: each part of the histogram holds equally many values.
        width = info["histogram_width"]
        self.assertEqual((info["histogram_low"], width % 2), (physical[0], 0))
        for i, share in enumerate(info["histogram"]):
            low = physical[0] + i * width
            self.assertAlmostEqual(share * COUNT, sum(low <= v < low + width for v in physical), places=6)

        # z has four times the spacing of x and y: it is not halved until they have caught up.
        self.assertEqual([level["dims"] for level in info["levels"]][:2], [[20, 18, 9], [10, 9, 9]])
        self.assertEqual(info["levels"][0]["bricks_per_axis"], [3, 3, 2])
        self.assertTrue(all(n <= 8 for n in info["levels"][-1]["dims"]))
        self.assertEqual(sum(level["bricks"] for level in info["levels"]), info["bricks"])
        self.assertEqual(len(info["brick_list"]), info["bricks"])
        self.assertEqual(sum(b["bytes"] for b in info["brick_list"]), sum(l["payload_bytes"] for l in info["levels"]))
        self.assertLessEqual(info["bricks_active"], info["bricks_interval"])
        self.assertLessEqual(info["bricks_interval"], info["levels"][0]["bricks"])
        self.assertNotIn("macrocells", info)
        finer = self.json("info", "a.brick", "--tf", "gray", "--macrocells")
        self.assertEqual(finer["bricks_active"], info["bricks_active"])
        self.assertLessEqual(finer["bricks_with_active_macrocells"], finer["bricks_active"])
        self.assertLessEqual(finer["macrocells_active"], finer["macrocells"])
        self.assertGreater(finer["macrocells_active"], 0)
        self.fails(2, "--macrocells goes with --tf", "info", "a.brick", "--macrocells")
        self.assertNotIn(self.folder, info["provenance"])

        for level in info["levels"]:
            self.assertAlmostEqual(level["ratio"], level["voxel_bytes"] / level["payload_bytes"])
        sizes = sorted(b["bytes"] for b in info["brick_list"] if not b["constant"])
        self.assertEqual([info["brick_bytes"][k] for k in ["count", "smallest", "largest"]],
                         [len(sizes), sizes[0], sizes[-1]])
        self.assertEqual(sum(info["brick_bytes"]["by_share_of_decoded"]), len(sizes))
        self.assertEqual(info["brick_bytes"]["percentiles"]["50"], sizes[(len(sizes) - 1) // 2])

        # Shares of bricks by isovalue: from the ranges of the list, which are widened by rounding at the most.
        active = info["active"]
        ranges = [b["range"] for b in info["brick_list"] if b["level"] == 0]
        self.assertEqual([active["values"][0], active["values"][-1]], info["range"])
        for value, crossed, above, voxels in zip(*(active[k] for k in ["values", "bricks_crossed", "bricks_above",
                                                                       "voxels_above"])):
            for share, inside in [(crossed, lambda lo, hi, e: lo - e <= value <= hi + e),
                                  (above, lambda lo, hi, e: hi + e >= value)]:
                least, most = (sum(inside(*r, e) for r in ranges) / len(ranges) for e in [0, 0.01])
                self.assertTrue(least - 1e-9 <= share <= most + 1e-9, (value, share, least, most))
            self.assertAlmostEqual(voxels, sum(v >= value for v in physical) / COUNT, places=9)

        text = self.brick("info", "a.brick", "--bricks", "--tf", "gray")
        for fact in ["20 x 18 x 9", "i16", "RAS", "histogram", "percentiles", "provenance", "visible"]:
            self.assertIn(fact, text)

    def test_f32_histogram(self):
        """Bins of f32 are wider than the parts near the ends: what they hold is spread, and nothing is lost."""
        values = [1000 + 0.01 * i for i in range(COUNT)]
        self.write("a.raw", cli.pack("f32", values))
        self.brick("convert", "a.raw", "--size", "20x18x9", "--type", "f32", "-o", "a.brick", "--quiet")
        info = self.json("info", "a.brick")
        self.assertEqual(len(info["histogram"]), 256)
        self.assertAlmostEqual(math.fsum(info["histogram"]), 1, places=9)
        # A ramp: equal shares, but for what one bin (8 of 32.4) puts beside its place.
        for part in range(0, 256, 64):
            self.assertAlmostEqual(math.fsum(info["histogram"][part:part + 64]), 1 / 4, delta=0.05)
        self.assertEqual(info["active"]["voxels_above"][0], 1)

    def test_log_scale(self):
        """One voxel in 5832 has a bar only on the logarithmic scale."""
        self.write("a.raw", cli.pack("u8", [0] * 5831 + [255]))
        self.brick("convert", "a.raw", "--size", "18x18x18", "--type", "u8", "-o", "a.brick", "--quiet")
        last = [self.brick("info", "a.brick", *log).split("histogram")[1].split("level")[0].strip().splitlines()[-1]
                for log in [[], ["--log"]]]
        self.assertEqual([line.count("#") for line in last], [0, 3])

    def test_tables_only(self):
        """No payload is read: damage there does not stop info."""
        self.brick("synth", "ct", "--size", "40x40x40", "-o", "a.brick", "--quiet")
        before, data = self.brick("info", "a.brick", "--bricks"), bytearray(self.read("a.brick"))
        data[600] ^= 1
        self.write("a.brick", data)
        self.fails(1, "checksum", "verify", "a.brick")
        self.assertEqual(self.brick("info", "a.brick", "--bricks"), before)

    def test_constant_bricks(self):
        self.brick("synth", "constant", "--size", "40x40x40", "--type", "u8", "--value", "9", "-o", "a.brick", "--quiet")
        info = self.json("info", "a.brick")
        self.assertEqual(info["bricks_constant"], info["bricks"])
        self.assertEqual(info["range"], [9, 9])
        self.assertEqual(info["levels"][0]["payload_bytes"], 0)
        self.assertEqual(set(info["active"]["bricks_crossed"]), {1})
        self.brick("info", "a.brick")


cli.main()

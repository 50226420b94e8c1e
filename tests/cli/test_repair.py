"""brick repair from outside: what it says, what it leaves on disk, exit codes."""

import json
import struct

import cli


class Repair(cli.Case):
    def setUp(self):
        super().setUp()
        self.brick("synth", "ct", "--size", "40x36x30", "--type", "u16", "--brick", "8", "-o", "a.brick", "--quiet")
        self.good = self.read("a.brick")

    def spoil(self, at, n=1, name="bad.brick"):
        data = bytearray(self.good)
        data[at:at + n] = bytes(b ^ 0x41 for b in data[at:at + n])
        self.write(name, bytes(data))

    def test_nothing_lost(self):
        index, = struct.unpack_from("<Q", self.good, 192 + 24)
        for at, part in [(100, "header"), (index + 77, "index"), (index - 10, "level table")]:
            self.spoil(at)
            self.assertIn(part, self.json("repair", "bad.brick", "-o", "b.brick", "--quiet")["damaged"])
            self.assertEqual(self.read("b.brick"), self.good, part)
        self.write("bad.brick", self.good)
        result = self.run_brick("repair", "bad.brick", "-o", "b.brick")
        self.assertEqual((result.returncode, result.stdout), (0, ""))
        self.assertIn("tables whole", result.stderr)
        self.assertEqual(self.read("b.brick"), self.good)

    def test_losses_are_listed(self):
        bricks = self.json("info", "a.brick", "--bricks")["brick_list"]
        hit = [b for b in bricks if b["bytes"]][3:6:2]
        data = bytearray(self.good)
        for b in hit:
            data[b["offset"] + b["bytes"] // 2] ^= 1
        self.write("bad.brick", bytes(data))
        result = self.run_brick("repair", "bad.brick", "-o", "b.brick", "--quiet")
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn("2 bricks of level 0 are lost", result.stderr)
        lines = result.stdout.splitlines()
        self.assertEqual(len(lines), 2)
        for line in lines:
            self.assertRegex(line, r"^brick \d+ \(\d+,\d+,\d+\) is lost: \d+ of its \d+ voxels are in its neighbours' "
                                   r"borders, the others from level 1$")
        self.brick("verify", "b.brick")
        result = self.run_brick("repair", "bad.brick", "-o", "b.brick", "--quiet", "--json")
        self.assertEqual(result.returncode, 1)
        report = json.loads(result.stdout)
        self.assertEqual((report["bricks_lost"], len(report["lost"]), report["damaged"]), (2, 2, []))

    def test_cut(self):
        self.write("bad.brick", self.good[:-1])
        result = self.run_brick("repair", "bad.brick", "-o", "b.brick", "--quiet")
        self.assertEqual((result.returncode, result.stdout), (1, ""))
        self.assertRegex(result.stderr, r"^brick repair: .*the provenance is lost.*\n$")
        self.brick("export", "a.brick", "-o", "a.raw")
        self.brick("export", "b.brick", "-o", "b.raw")
        self.assertEqual(self.read("a.raw"), self.read("b.raw"))

    def test_refusals(self):
        self.spoil(90, 100)
        self.fails(1, "header", "repair", "bad.brick", "-o", "b.brick")
        self.write("bad.brick", self.good[:300])
        self.fails(1, "header", "repair", "bad.brick", "-o", "b.brick")
        self.write("bad.brick", bytes(512) + self.good[512:])
        self.fails(1, "unfinished.*--resume", "repair", "bad.brick", "-o", "b.brick")
        self.write("bad.brick", self.good)
        self.fails(1, "--memory", "repair", "bad.brick", "-o", "b.brick", "--memory", "1K")
        self.fails(1, "missing.brick", "repair", "missing.brick", "-o", "b.brick")
        self.fails(1, "nowhere", "repair", "bad.brick", "-o", "nowhere/b.brick")
        self.fails(2, "only copy", "repair", "bad.brick", "-o", "./bad.brick")
        self.fails(2, "no output", "repair", "bad.brick")
        self.fails(2, "end in .brick", "repair", "bad.brick", "-o", "b.raw")


cli.main()

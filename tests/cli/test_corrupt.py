"""A flipped byte anywhere in a file, a shortened file and a lengthened one are reported, never passed over."""

import random

import cli


class Corrupt(cli.Case):
    def setUp(self):
        super().setUp()
        # Two levels, constant and coded bricks, about ten kilobytes.
        source = random.Random(3)
        values = [0 if i < 2000 else source.randint(0, 40) for i in range(20 * 18 * 14)]
        self.write("a.raw", cli.pack("u8", values))
        self.brick("convert", "a.raw", "--size", "20x18x14", "--type", "u8", "--brick", "8", "--macrocell", "4", "-o",
                   "a.brick", "--quiet")
        self.good = self.read("a.brick")

    def rejected(self, data, what):
        self.write("bad.brick", data)
        result = self.run_brick("verify", "bad.brick")
        self.assertEqual(result.returncode, 1, "%s was not noticed: %s" % (what, result.stderr))
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)

    def test_flipped_bytes(self):
        # Every byte of the first kilobyte (header), then a spread of all the rest, ends included.
        places = list(range(min(1024, len(self.good))))
        places += sorted(random.Random(1).sample(range(len(self.good)), min(700, len(self.good))))
        places += list(range(len(self.good) - 64, len(self.good)))
        for place in places:
            data = bytearray(self.good)
            data[place] ^= 1 << (place % 8)
            self.rejected(bytes(data), "a flipped bit in byte %d of %d" % (place, len(self.good)))

    def test_length(self):
        for n in [0, 1, 100, len(self.good) // 2, len(self.good) - 1]:
            self.rejected(self.good[:n], "a cut to %d bytes" % n)
        self.rejected(self.good + b"\0", "a byte too many")

    def test_other_commands_refuse_too(self):
        data = bytearray(self.good)
        entry = max(self.json("info", "a.brick", "--bricks")["brick_list"], key=lambda b: b["bytes"])
        data[entry["offset"] + entry["bytes"] // 2] ^= 1
        self.write("bad.brick", bytes(data))
        self.fails(1, "brick", "export", "bad.brick", "-o", "a.nrrd")
        if cli.HAS_EXR:
            self.fails(1, "brick", "render", "bad.brick", "--method", "exact", "--size", "16x16", "-o", "a.exr")
        if cli.HAS_EGL or cli.HAS_OSMESA:
            self.fails(1, "brick", "render", "bad.brick", "--size", "16x16", "-o", "a.exr")


cli.main()

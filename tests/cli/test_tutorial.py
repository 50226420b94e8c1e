"""The tutorial: its commands run as they stand, one after the other, and leave what it says."""

import os
import re
import subprocess

import cli


def blocks(text):
    """The commands: what is indented, block by block."""
    return [re.sub(r"(?m)^    ", "", block) for block in re.findall(r"(?:(?:^    .*|^)\n)+", text, re.M) if block.strip()]


@cli.needs_ct
@cli.needs_png
@cli.needs_exr
class Tutorial(cli.Case):
    @cli.unittest.skipUnless(cli.HAS_OBJ, "built without OBJ")
    def test_commands(self):
        os.makedirs(self.path("quickstart-out"))
        os.makedirs(self.path("build"))
        os.symlink(os.path.dirname(cli.BRICK), self.path("build/tools"))
        self.ct(name="quickstart-out/cranium.brick")
        with open(os.environ["BRICK_TUTORIAL"]) as file:
            commands = blocks(file.read())
        self.assertGreater(len(commands), 10)
        result = subprocess.run(["bash", "-e"], input="\n".join(commands), cwd=self.folder, capture_output=True, text=True,
                                timeout=280)
        self.assertEqual(result.returncode, 0, result.stderr)
        print(result.stdout)
        names = re.findall(r"-o (\S+\.\w+)", "".join(commands))
        numbered = {"turn.png": 12, "flight.png": 4}
        for name in names:
            for number in range(numbered.get(name, 1)):
                made = name.replace(".", "-%04d." % number) if name in numbered else name
                self.assertTrue(os.path.getsize(self.path("quickstart-out/" + made)) > 100, made)
        self.assertIn("<html", self.read("quickstart-out/report.html").decode().lower())
        rmse = [float(r) for r in re.findall(r"^rmse +(\S+)", result.stdout, re.M)]
        self.assertEqual(len(rmse), 4)
        for coarse, fine in zip(rmse, rmse[1:]):
            self.assertGreater(coarse / fine, 3)
        self.assertEqual("%.4f" % rmse[2], "0.0017")
        for claim in ["three coarser levels", "bricks of 32^3"]:
            with open(os.environ["BRICK_TUTORIAL"]) as file:
                self.assertIn(claim, " ".join(file.read().split()))
        self.assertEqual(set(re.findall(r"(?m)^ +(\d)  \d+ x \d+ x \d+ ", result.stdout)), set("0123"))


cli.main()

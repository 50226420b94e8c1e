"""A program outside the tree, compiled against what meson installs and found by pkg-config, reads a voxel."""

import glob
import os
import shutil
import subprocess

import cli


class Install(cli.Case):
    def test_consumer(self):
        for tool in ["cc", "pkg-config", "meson"]:
            if not shutil.which(tool):
                self.skipTest("no " + tool)
        root = self.path("root")
        subprocess.run(["meson", "install", "-C", os.environ["BRICK_BUILD"], "--no-rebuild", "--quiet", "--destdir", root],
                       check=True, capture_output=True)
        found = glob.glob(root + "/**/libbrick.pc", recursive=True)
        self.assertEqual(len(found), 1, found)
        self.assertEqual(len(glob.glob(root + "/**/man1/brick.1", recursive=True)), 1)
        env = {**os.environ, "PKG_CONFIG_PATH": os.path.dirname(found[0]), "PKG_CONFIG_SYSROOT_DIR": root}
        flags = subprocess.run(["pkg-config", "--static", "--cflags", "--libs", "libbrick"], check=True, env=env,
                               capture_output=True, text=True).stdout.split()
        subprocess.run(["cc", "-std=c11", "-Wall", "-Werror", os.environ["BRICK_CONSUMER"], "-o", self.path("consumer"),
                        *flags], check=True)
        libraries = glob.glob(root + "/**/libbrick.so", recursive=True)
        if libraries:
            env["LD_LIBRARY_PATH"] = os.path.dirname(libraries[0])

        values = [(7 * i) % 251 for i in range(20 * 10 * 5)]
        self.write("a.raw", cli.pack("u8", values))
        self.brick("convert", "a.raw", "--size", "20x10x5", "--type", "u8", "--brick", "8", "-o", "a.brick", "--quiet")
        out = subprocess.run([self.path("consumer"), self.path("a.brick"), "17", "9", "3"], env=env, check=True,
                             capture_output=True, text=True).stdout
        self.assertEqual(out, "%d\n" % values[17 + 20 * (9 + 10 * 3)])

        # The installed program runs, too.
        program = glob.glob(root + "/**/bin/brick", recursive=True)
        self.assertEqual(subprocess.run([program[0], "verify", self.path("a.brick")], env=env).returncode, 0)


cli.main()

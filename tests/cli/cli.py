"""Shared by the tests of the program: run it in a temporary folder and look at what it says and leaves."""

import ctypes
import json
import os
import shutil
import struct
import subprocess
import sys
import tarfile
import tempfile
import unittest

BRICK = os.environ["BRICK"]
CT_ARCHIVE = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3"
CT_OPTIONS = ["--size", "256x256x108", "--type", "i16", "--spacing", "0.9570312,0.9570312,1.5", "--axes", "LAS"]

FORMATS = {"u8": "B", "i8": "b", "u16": "H", "i16": "h", "u32": "I", "i32": "i", "f32": "f", "f64": "d"}


def has_library(name):
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


HAS_EXR = os.environ["BRICK_EXR"] == "1"
HAS_PNG = os.environ["BRICK_PNG"] == "1"
HAS_OBJ = os.environ["BRICK_OBJ"] == "1"
HAS_GL = os.environ["BRICK_GL"] == "1" and HAS_EXR
HAS_EGL = HAS_GL and has_library("libEGL.so.1")
HAS_OSMESA = HAS_GL and has_library("libOSMesa.so.8")

needs_exr = unittest.skipUnless(HAS_EXR, "built without OpenEXR")
needs_zlib = unittest.skipUnless(os.environ["BRICK_ZLIB"] == "1", "built without zlib")
needs_png = unittest.skipUnless(HAS_PNG, "built without libpng")
needs_gl = unittest.skipUnless(HAS_EGL or HAS_OSMESA, "no OpenGL in this build or on this machine")
needs_egl_and_osmesa = unittest.skipUnless(HAS_EGL and HAS_OSMESA, "needs both EGL and OSMesa")
needs_ct = unittest.skipUnless(os.path.exists(CT_ARCHIVE), "package invesalius-examples is not installed")


def pack(kind, values, endian="<"):
    return struct.pack("%s%d%s" % (endian, len(values), FORMATS[kind]), *values)


def unpack(kind, data, endian="<"):
    return struct.unpack("%s%d%s" % (endian, len(data) // struct.calcsize(FORMATS[kind]), FORMATS[kind]), data)


class Case(unittest.TestCase):
    """Every test has an empty folder of its own as the working directory."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="brick-cli-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, data):
        with open(self.path(name), "wb") as file:
            file.write(data)
        return name

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def run_brick(self, *args):
        return subprocess.run([BRICK, *args], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, timeout=600)

    def brick(self, *args):
        """Must succeed; returns stdout."""
        result = self.run_brick(*args)
        self.assertEqual(result.returncode, 0, "brick %s: %s" % (" ".join(args), result.stderr))
        return result.stdout

    def json(self, *args):
        return json.loads(self.brick(*args, "--json"))

    def fails(self, code, mention, *args):
        """Must end with that exit code and one line that mentions something, and leave no file behind."""
        before = sorted(os.listdir(self.folder))
        result = self.run_brick(*args)
        said = "brick %s: %r" % (" ".join(args), result.stderr)
        self.assertEqual(result.returncode, code, said)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 1, said)
        self.assertTrue(lines[0].startswith("brick"), said)
        self.assertRegex(lines[0].lower(), mention.lower(), said)
        self.assertEqual(result.stdout, "", said)
        self.assertEqual(sorted(os.listdir(self.folder)), before, said)
        return lines[0]

    def ct(self, *options, name="ct.brick"):
        """The real CT, converted."""
        if not os.path.exists(self.path("ct.raw")):
            with tarfile.open(CT_ARCHIVE) as archive:
                member = next(m for m in archive.getmembers() if m.name.endswith("matrix.dat"))
                self.write("ct.raw", archive.extractfile(member).read())
        self.brick("convert", "ct.raw", *CT_OPTIONS, "-o", name, "--quiet", *options)
        return name


def main():
    """Exit code 77, which meson counts as skipped, when nothing could be tested here."""
    result = unittest.main(exit=False).result
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(77 if result.testsRun == len(result.skipped) else 0)

"""Does converting 16 GiB take as long for a byte as 1 GiB, and checking a file as long as half of reading it?

    python3 tests/bench/throughput.py build/tools/brick FOLDER [--large 2048x2048x2048] [--repeat 3]

makes u16 phantoms in FOLDER (twice the larger one's size of disk), converts them in turns, one and two threads, verifies,
reads with dd, prints medians, and removes what it made. Core-seconds hardly depend on what else the machine does."""

import argparse
import json
import os
import resource
import statistics
import subprocess
import time


def run(*args):
    """Seconds, core-seconds, stdout."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    out = subprocess.run(args, check=True, stdout=subprocess.PIPE).stdout
    wall, after = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, out


def row(name, size, rounds, extra=""):
    wall, cores = (statistics.median(r[i] for r in rounds) for i in range(2))
    print("| %s | %.2f | %.2f | %.2f | %.2f%s |" % (name, wall, size / wall / 1e9, cores, cores / size * 2 ** 30, extra), flush=True)
    return wall


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("brick")
    parser.add_argument("folder")
    parser.add_argument("--small", default="512x1024x1024")
    parser.add_argument("--large", default="2048x2048x2048")
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    path = lambda name: os.path.join(options.folder, name)
    print("| | seconds | GB/s | core-seconds | core-seconds a GiB | peak RSS MB |\n|---|---|---|---|---|---|")
    for size in [options.small, options.large]:
        raw, brick = path("throughput.raw"), path("throughput.brick")
        run(options.brick, "synth", "ct", "--size", size, "--type", "u16", "-o", raw, "--quiet")
        convert = [options.brick, "convert", raw, "--size", size, "--type", "u16", "-o", brick, "--json", "--quiet", "--threads"]
        rounds = {threads: [] for threads in ["1", "2"]}
        for _ in range(options.repeat):
            for threads in rounds:
                os.sync()
                rounds[threads].append(run(*convert, threads))
        for threads, done in rounds.items():
            row("convert %s, %s threads" % (size, threads), os.path.getsize(raw), done,
                " | %.0f" % max(json.loads(r[2])["peak_rss_bytes"] / 1e6 for r in done))
        os.remove(raw)
        read, verify = [], []
        run("dd", "if=" + brick, "of=/dev/null", "bs=1M", "status=none")
        for _ in range(options.repeat):
            read.append(run("dd", "if=" + brick, "of=/dev/null", "bs=1M", "status=none"))
            verify.append(run(options.brick, "verify", brick))
        n = os.path.getsize(brick)
        a, b = row("dd of the file", n, read, " | "), row("verify", n, verify, " | ")
        print("verify goes at %.2f of the read bandwidth" % (a / b), flush=True)
        os.remove(brick)


main()

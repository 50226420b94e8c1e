"""What is left to do of a conversion that was killed when nine tenths of level 0 were written?

    python3 tests/bench/resume.py build/tools/brick FOLDER [--size 512x1024x1024] [--at 0.9] [--repeat 5]

makes a u16 phantom in FOLDER, converts it with several codecs, and, in turns, kills conversions and resumes them; prints medians and
their ratios, and removes what it made. Core-seconds hardly depend on what else the machine does."""

import argparse
import json
import os
import resource
import statistics
import subprocess
import time

CODECS = [["lz4"], ["none"], ["zstd"], ["zfp", "--tolerance", "2"]]
LEFT = ["", ".part", ".part.journal", ".part.levels"]


def run(args):
    """Seconds, core-seconds, what it says."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    out = subprocess.run(args, check=True, stdout=subprocess.PIPE).stdout
    wall, after = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, json.loads(out)


def remove(target):
    for ending in LEFT:
        if os.path.exists(target + ending):
            os.remove(target + ending)


def kill_at(args, part, size):
    """False: it was done before."""
    process = subprocess.Popen(args, stdout=subprocess.DEVNULL)
    while process.poll() is None and not (os.path.exists(part) and os.path.getsize(part) >= size):
        time.sleep(0.0005)
    process.kill()
    return process.wait() != 0


def measure(options, convert, target):
    whole, rest = [], []
    run(convert)
    level0 = run([options.brick, "info", target, "--json"])[2]["levels"][0]["payload_bytes"]
    while len(rest) < options.repeat:
        remove(target)
        whole.append(run(convert))
        with open(target, "rb") as f:
            good = f.read()
        remove(target)
        if not kill_at(convert, target + ".part", options.at * level0):
            continue
        rest.append(run(convert + ["--resume"]))
        with open(target, "rb") as f:
            if f.read() != good:
                raise SystemExit("resumed, it has other bytes")
    remove(target)
    return whole, rest


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("brick")
    parser.add_argument("folder")
    parser.add_argument("--size", default="512x1024x1024")
    parser.add_argument("--at", type=float, default=0.9)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    raw, target = (os.path.join(options.folder, "resume." + ending) for ending in ["raw", "brick"])
    subprocess.run([options.brick, "synth", "ct", "--size", options.size, "--type", "u16", "-o", raw, "--quiet"], check=True)
    print("| | whole s | rest s | rest / whole | core-seconds | kept | decoded | source read |\n|---|---|---|---|---|---|---|---|")
    for codec in CODECS:
        convert = [options.brick, "convert", raw, "--size", options.size, "--type", "u16", "-o", target, "--json", "--quiet",
                   "--codec", *codec]
        whole, rest = measure(options, convert, target)
        wall, cores = ([statistics.median(r[i] for r in rounds) for rounds in [whole, rest]] for i in range(2))
        said = rest[-1][2]
        share = lambda key, of: 100 * said[key] / said[of]
        print("| %s | %.2f | %.2f | %.2f | %.2f | %.0f%% | %.0f%% | %.0f%% |" % (
            " ".join(codec), *wall, wall[1] / wall[0], cores[1] / cores[0], share("bricks_kept", "bricks"),
            share("bricks_decoded", "bricks"), share("source_bytes_read", "input_bytes")), flush=True)
    os.remove(raw)


main()

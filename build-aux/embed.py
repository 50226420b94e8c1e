"""Text files as C strings: embed.py PREFIX OUTPUT.h INPUT... (a.vert.glsl -> PREFIX_a_vert: dots to underscores)."""
import pathlib
import sys

prefix, output = sys.argv[1:3]
guard = f"EMBEDDED_{prefix.upper()}_H"
out = ["/* Made by embed.py. */", f"#ifndef {guard}", f"#define {guard}"]
for name in sys.argv[3:]:
    path = pathlib.Path(name)
    symbol = path.stem.replace(".", "_")
    out.append(f"__attribute__((unused)) static const char {prefix}_{symbol}[] =")
    for line in path.read_text().splitlines():
        escaped = line.replace("\\", "\\\\").replace('"', '\\"')
        out.append(f'    "{escaped}\\n"')
    out[-1] += ";"
out.append("#endif")
pathlib.Path(output).write_text("\n".join(out) + "\n")

"""Shader sources as C strings: embed.py OUTPUT.h INPUT.glsl... (name.glsl -> vr_shader_name, dots to underscores)."""
import pathlib
import sys

out = ["/* Made by embed.py from the .glsl files. */", "#ifndef RENDERER_SHADERS_H", "#define RENDERER_SHADERS_H"]
for name in sys.argv[2:]:
    path = pathlib.Path(name)
    symbol = path.name.removesuffix(".glsl").replace(".", "_")
    out.append(f"__attribute__((unused)) static const char vr_shader_{symbol}[] =")
    for line in path.read_text().splitlines():
        escaped = line.replace("\\", "\\\\").replace('"', '\\"')
        out.append(f'    "{escaped}\\n"')
    out[-1] += ";"
out.append("#endif")
pathlib.Path(sys.argv[1]).write_text("\n".join(out) + "\n")

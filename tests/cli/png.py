"""Reading a PNG of 8 bits a sample with Python's standard library alone."""

import struct
import zlib

CHANNELS = {0: 1, 2: 3, 6: 4}


def decode(data):
    """Returns width, height, channels and the samples as one bytearray, row after row."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("no PNG")
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0] != zlib.crc32(kind + body):
            raise ValueError("damaged")
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            if depth != 8 or interlace:
                raise ValueError("not 8 bits, or interlaced")
            channels = CHANNELS[colour]
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    raw, stride, out = zlib.decompress(packed), width * channels, bytearray()
    before = bytearray(stride)
    for y in range(height):
        how, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        if how:
            for i in range(stride):
                left = row[i - channels] if i >= channels else 0
                corner = before[i - channels] if i >= channels else 0
                row[i] = (row[i] + predict(how, left, before[i], corner)) & 255
        out += row
        before = row
    return width, height, channels, out


def predict(how, left, up, corner):
    if how == 4:
        guess = left + up - corner
        return min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
    return [0, left, up, (left + up) // 2][how]

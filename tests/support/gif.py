"""Reads animated GIF files as a browser would: frames of RGB pixels and how long each is shown."""


class Bits:
    def __init__(self, data):
        self.data, self.at, self.value, self.count = data, 0, 0, 0

    def take(self, width):
        while self.count < width:
            self.value |= self.data[self.at] << self.count
            self.at += 1
            self.count += 8
        code = self.value & ((1 << width) - 1)
        self.value >>= width
        self.count -= width
        return code


def unpack(data, bits):
    """The indices that LZW codes stand for."""
    clear, end = 1 << bits, (1 << bits) + 1
    codes, out, table, width, before = Bits(data), bytearray(), [], bits + 1, None
    while (code := codes.take(width)) != end:
        if code == clear:
            table = [bytes([i]) for i in range(clear)] + [b"", b""]
            width, before = bits + 1, None
            continue
        entry = table[code] if code < len(table) else before + before[:1]
        assert code <= len(table), "a code that is not known yet"
        out += entry
        if before is not None and len(table) < 4096:
            table.append(before + entry[:1])
        if len(table) == 1 << width and width < 12:
            width += 1
        before = entry
    return bytes(out)


def read_gif(data):
    """(width, height, [(hundredths, RGB bytes)]) of a file that loops without end."""
    assert data[:6] == b"GIF89a" and data[-1:] == b"\x3b", "no whole GIF"
    number = lambda at: data[at] | data[at + 1] << 8
    width, height = number(6), number(8)
    assert data[10] & 0x80 == 0, "colours for all frames are not written"
    canvas, frames, at, delay, transparent, loops = bytearray(3 * width * height), [], 13, 0, None, False

    def blocks(at):
        out = bytearray()
        while data[at]:
            out += data[at + 1:at + 1 + data[at]]
            at += 1 + data[at]
        return bytes(out), at + 1

    while data[at] != 0x3b:
        if data[at] == 0x21:
            kind = data[at + 1]
            content, at = blocks(at + 2)
            loops = loops or content.startswith(b"NETSCAPE2.0")
            if kind == 0xf9:
                assert content[0] >> 2 & 7 == 1, "frames stay"
                delay, transparent = content[1] | content[2] << 8, content[3] if content[0] & 1 else None
            continue
        assert data[at] == 0x2c, data[at]
        left, top, w, h, flags = number(at + 1), number(at + 3), number(at + 5), number(at + 7), data[at + 9]
        size = 3 << (flags & 7) + 1
        palette, at = data[at + 10:at + 10 + size], at + 10 + size
        bits = data[at]
        packed, at = blocks(at + 1)
        indices = unpack(packed, bits)
        assert len(indices) == w * h and left + w <= width and top + h <= height
        for i, index in enumerate(indices):
            if index != transparent:
                to = 3 * ((top + i // w) * width + left + i % w)
                canvas[to:to + 3] = palette[3 * index:3 * index + 3]
        frames.append((delay, bytes(canvas)))
    assert loops, "it is played once"
    return width, height, frames

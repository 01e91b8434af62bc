"""Where the entities of a kind were in a run, read from its scene.bin as docs/reference/run-folder.md describes the file."""

import bisect
import pathlib

MAGIC = b"CXSCENE1"
LENGTH, CHECKSUM = 4, 8
X, Y, YAW, REST, STATE, CARRIER, WAY, MORE = (1 << bit for bit in range(8))
GONE, NEW = 0, 1
STEP = 0.2  # s


class Bytes:
    def __init__(self, data):
        self.data, self.at = data, 0

    def varint(self):
        value = shift = 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def zigzag(self):
        value = self.varint()
        return value >> 1 if value % 2 == 0 else -(value >> 1) - 1

    def byte(self):
        self.at += 1
        return self.data[self.at - 1]

    def text(self, spelt):
        number = self.varint()
        if number == len(spelt) + 1:
            length = self.varint()
            spelt.append(self.data[self.at:self.at + length].decode())
            self.at += length
        return spelt[number - 1] if number else ""

    def pose(self, fields, x, y):
        """The numbers of a pose that changed: here x and y, in mm, count."""
        x += self.zigzag() if fields & X else 0
        y += self.zigzag() if fields & Y else 0
        for _ in range(bool(fields & YAW) + 3 * bool(fields & REST)):
            self.zigzag()
        return x, y


class SceneTracks:
    """`SceneTracks(run, "robot").at("robot1", 312.4)`: x and y in m."""

    def __init__(self, run, kind):
        self.points = {}  # by name: times in s, and the places from then on, points (t, x, y)
        data = (pathlib.Path(run) / "scene.bin").read_bytes()
        assert data.startswith(MAGIC)
        at = len(MAGIC)
        while at < len(data):
            length = int.from_bytes(data[at:at + LENGTH], "little")
            at += LENGTH + CHECKSUM
            self.read_chunk(Bytes(data[at:at + length]), kind)
            at += length

    def read_chunk(self, chunk, wanted):
        spelt, known = [], {}
        t = chunk.varint()
        chunk.varint()
        while chunk.at < len(chunk.data):
            t += chunk.varint()
            while number := chunk.varint():
                self.read_change(chunk, number, known, spelt, t / 1e9, wanted)

    def read_change(self, chunk, number, known, spelt, t, wanted):
        fields = chunk.byte()
        if fields & MORE:
            more = chunk.byte()
            if more == GONE:
                del known[number]
                return
            if more == NEW:
                known[number] = [chunk.text(spelt), chunk.text(spelt), [], 0, 0]
            chunk.text(spelt)
        entity = known[number]
        entity[3:] = chunk.pose(fields, *entity[3:])
        if fields & STATE:
            chunk.text(spelt)
        if fields & CARRIER:
            chunk.varint()
            chunk.text(spelt)
        if fields & WAY:
            entity[2], then, place = [], 0, (0, 0)
            for _ in range(chunk.varint()):
                then += chunk.varint()
                place = chunk.pose(chunk.byte(), *place)
                entity[2].append((then / 1e3, place[0] / 1e3, place[1] / 1e3))
        kind, name, way, x, y = entity
        if kind == wanted:
            times, places = self.points.setdefault(name, ([], []))
            times.append(t)
            places.append(way or [(t, x / 1e3, y / 1e3)])

    def way(self, name, begin, end):
        """Its places between two times, `STEP` apart."""
        return [self.at(name, begin + i * STEP) for i in range(int((end - begin) / STEP) + 1)]

    def at(self, name, t):
        times, places = self.points[name]
        way = places[max(bisect.bisect_right(times, t) - 1, 0)]
        after = bisect.bisect_right(way, (t, 1e9, 1e9))
        if after in (0, len(way)):
            return way[min(after, len(way) - 1)][1:]
        (t0, x0, y0), (t1, x1, y1) = way[after - 1:after + 1]
        share = (t - t0) / (t1 - t0) if t1 > t0 else 1
        return x0 + share * (x1 - x0), y0 + share * (y1 - y0)

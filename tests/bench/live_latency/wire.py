"""The few messages of lcmtypes/ that live_latency reads, by their fields (big endian, after the
fingerprint of 8 bytes)."""
import struct, zlib
from collections import namedtuple

Tile = namedtuple("Tile", "utime seq key revision encoding data")
EMPTY, CELLS = 0, 64 * 64


class Reader:
    def __init__(self, content):
        self.content, self.at = content, 8

    def take(self, fields):
        values = struct.unpack_from(">" + fields, self.content, self.at)
        self.at += struct.calcsize(">" + fields)
        return values if len(values) != 1 else values[0]

    def text(self):
        n = self.take("i")
        self.at += n
        return self.content[self.at - n:self.at - 1].decode(errors="replace")


def utime(content):
    return Reader(content).take("q")


def keyframe_id(content):  # keyframe_t, keyframe_image_t
    return Reader(content).take("qqq")[2]


def tile(content):
    r = Reader(content)
    when, seq, submap, x, y, z, revision, _, _, encoding, size = r.take("qqqiiiqdibi")
    data = zlib.decompress(content[r.at:r.at + size]) if size else b""
    return Tile(when, seq, (submap, x, y, z), revision, encoding, data)


def graph_keyframes(content):
    """Ids of the keyframes in a graph_t."""
    r = Reader(content)
    n = r.take("qqqbiii")[6]
    nodes = [r.take("bqqq7d") for _ in range(n)]
    return [node[1] for node in nodes if node[0] == 0]


def status(content):
    r = Reader(content)
    r.take("qq")
    s = {"process": r.text(), "host": r.text()}
    r.take("ib"), r.text(), r.take("qi3d")
    s["cpu_s"], s["peak_rss_bytes"] = r.take("dq")
    s["error"] = r.text()
    s["channels"] = {}
    for _ in range(r.take("i")):
        name = r.text()
        (s["channels"][name],) = [dict(zip(
            "subscribed published received processed dropped lost late".split(), r.take("b6q")))]
        r.take("4q")
    return s


# --- cells of grid tiles (docs/tiles.md, services/fuser/fusion_rule.cpp)
def probability(cell):
    return 0.5 if cell == 0 else (cell - 1) / 254.0


def state(cell):  # 1 occupied, -1 unoccupied, 0 no verdict
    p = probability(cell)
    return 0 if cell == 0 else 1 if p > 0.65 else -1 if p < 0.25 else 0


def fused(lidar, camera):
    """Equation 8 and Table 1 of a cell; neither behind a face nor an inside."""
    a, b = probability(lidar), probability(camera)
    occupied, both = a * b, a * b + (1.0 - a) * (1.0 - b)
    p = 0.5 if both == 0.0 else occupied / both
    states = (state(lidar), state(camera))
    if 1 in states:
        p = max(p, a, b)
    elif -1 in states:
        p = min(p, a, b)
    return 1 + int(min(1.0, max(0.0, p)) * 254.0 + 0.5)

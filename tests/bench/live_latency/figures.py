"""What the messages of a live session say about latency."""
from collections import defaultdict
from wire import CELLS, EMPTY, fused, graph_keyframes, keyframe_id, state, tile, utime

WHOLE = {"GRAPH", "GRID_VISUAL", "GRID_LIDAR", "GRID_FUSED", "STATUS"}
UPDATE_S = 1.0  # tiles of one update of the dense mapper come closer together than this


def quantile(values, q):
    return sorted(values)[min(len(values) - 1, int(q * len(values)))] if values else float("nan")


def row(name, values_s):
    ms = [1e3 * v for v in values_s]
    cells = [f"{quantile(ms, q):.1f}" for q in (0.5, 0.95, 0.99, 1.0)] if ms else ["-"] * 4
    return [name, str(len(ms))] + cells


class Session:
    def __init__(self, messages):
        self.by_channel = defaultdict(list)
        for message in sorted(messages, key=lambda m: m[0]):
            self.by_channel[message[1]].append((message[0], message[2]))
        self.sent = {c: {utime(x): t for t, x in reversed(self.by_channel[c])}
                     for c in ("CAMERA", "LIDAR", "VISUAL_POSE", "LIDAR_POSE", "POSE")}
        self.read_tiles()

    def from_to(self, *channels):
        """Seconds from a measurement's message to the first of that time on a later channel."""
        chain = [self.sent[c] for c in channels]
        return [chain[-1][u] - chain[0][u] for u in chain[0] if all(u in c for c in chain)]

    def without_pose(self):
        """Frames of the camera that no VISUAL_POSE answers: before the first of them, and later."""
        answered = self.sent["VISUAL_POSE"]
        missing = [u for u in self.sent["CAMERA"] if u not in answered]
        first = min(answered, default=2**63)
        return sum(u < first for u in missing), sum(u > first for u in missing)

    def read_tiles(self):
        self.tiles = {c: [(t, tile(x)) for t, x in self.by_channel[c]]
                      for c in ("GRID_VISUAL", "GRID_LIDAR", "GRID_FUSED")}
        self.of_key = {c: defaultdict(list) for c in self.tiles}
        for channel, tiles in self.tiles.items():
            for t, x in tiles:
                self.of_key[channel][x.key].append((t, x))

    def update_of(self, when, image_utime):
        """The GRID_VISUAL tiles of the dense mapper's first update that has this image in it."""
        update = []
        for t, x in self.tiles["GRID_VISUAL"]:
            if x.utime < image_utime or t < when:
                continue
            if update and (x.utime != update[0][1].utime or t > update[0][0] + UPDATE_S or
                           x.key in {y.key for _, y in update}):
                break
            update.append((t, x))
        return update

    def carried(self, key, revision):
        """When the first GRID_FUSED tile came whose cells can only stem from this revision of the
        camera's tile, or a newer one. None when the revision changes no cell that would show it."""
        visual = self.of_key["GRID_VISUAL"][key]
        at = next(i for i, (_, x) in enumerate(visual) if x.revision == revision)
        before = visual[at - 1][1] if at else None
        for t, x in self.of_key["GRID_FUSED"][key]:
            if t < visual[at][0]:
                continue
            lidar = [y for u, y in self.of_key["GRID_LIDAR"][key] if u <= t]
            cells = lidar[-1].data if lidar and lidar[-1].encoding != EMPTY else bytes(CELLS)
            says = [says_so(x, y, before, cells) for u, y in visual[at:] if u <= t]
            if says[0] is None:
                return None
            if any(says):
                return t
        return None

    def keyframes(self):
        """For each keyframe that changed tiles: seconds from KEYFRAME to GRAPH, to GRID_VISUAL, to
        the first GRID_FUSED tile that carries it, and to the last of them."""
        in_graph = {}
        for t, content in self.by_channel["GRAPH"]:
            for id in graph_keyframes(content):
                in_graph.setdefault(id, t)
        rows, shown_by_none = [], 0
        for t, content in self.by_channel["KEYFRAME"]:
            update = self.update_of(t, utime(content))
            carried = [c for _, x in update if (c := self.carried(x.key, x.revision))]
            if not carried:
                shown_by_none += 1
                continue
            rows.append((in_graph.get(keyframe_id(content), t) - t, update[0][0] - t,
                         min(carried) - t, max(carried) - t))
        return rows, shown_by_none


def says_so(tile, visual, before, lidar):
    """Does a fused tile hold this camera's tile? By the cells that changed against `before` where
    equation 8 and Table 1 alone decide. None: there is no such cell."""
    if EMPTY in (tile.encoding, visual.encoding):
        return None
    old = before.data if before and before.encoding != EMPTY else bytes(CELLS)
    decisive = 0
    for i, cell in enumerate(visual.data):
        if cell == old[i] or state(cell) == 0 or state(lidar[i]) == 1:
            continue
        if fused(lidar[i], cell) == fused(lidar[i], old[i]):
            continue
        decisive += 1
        if tile.data[i] != fused(lidar[i], cell):
            return False
    return True if decisive else None

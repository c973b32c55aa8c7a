"""Cost against work: keyframes, area, robots."""

import re

from harness.curves import exponent, growth, svg

KEYFRAMES = (100, 300, 1000, 3000, 10000)
SIDES_M = (10, 32, 100, 316)
# Above these one machine's core or memory is taken by the part alone.
REAL_TIME_MS, MACHINE_MB = 100.0, 4000.0


def keyframes(bench, most):
    """Asking where a place is, solving the graph, and what both hold in memory."""
    query, quick, whole, places_mb, graph_mb = [], [], [], [], []
    rows = []
    for n in [k for k in KEYFRAMES if k <= most]:
        text, mb = bench.measured("place_index_bench", n)
        found = re.search(rf"{n} keyframes: median ([\d.]+) ms", text or "")
        if found:
            query.append((n, float(found.group(1))))
            places_mb.append((n, mb))
        text, mb = bench.measured("pose_graph_bench", n)
        solved = re.search(r"quick solve ([\d.]+) ms.*from scratch ([\d.]+) ms", text or "")
        if solved:
            quick.append((n, float(solved.group(1))))
            whole.append((n, float(solved.group(2))))
            graph_mb.append((n, mb))
        rows.append((n, found.group(1) if found else "-", solved.group(1) if solved else "-", solved.group(2) if solved else "-",
                     f"{places_mb[-1][1]:.0f}" if places_mb else "-", f"{graph_mb[-1][1]:.0f}" if graph_mb else "-"))
    rows.append(("growth", growth(query), growth(quick), growth(whole), growth(places_mb), growth(graph_mb)))
    bench.table("Scale: keyframes", "place_index_bench N; pose_graph_bench N",
                ["keyframes", "query, ms", "quick solve, ms", "global solve, ms", "index, MB", "graph, MB"], rows,
                "14 MB is the least that is seen: the measuring process's own. "
                + end_of_one_machine({"the query": query, "the quick solve": quick}, {"the index": places_mb}))
    bench.picture("scale-keyframes.svg", svg("Cost against keyframes", "keyframes", "ms",
                                             {"query": query, "quick solve": quick, "global solve": whole}))


def area(bench, most_m2):
    """The fused map: one change of either sensor, a submap moved, everything at once."""
    curves = {"one camera tile": [], "one LiDAR tile": [], "one submap moved": [], "all at once": []}
    memory, rows = [], []
    for side in [s for s in SIDES_M if s * s <= 1.1 * most_m2]:
        text, mb = bench.measured("area_bench", side)
        found = re.search(r"([\d.]+) m2, (\d+) tiles: all at once ([\d.]+) ms, one camera tile ([\d.]+) ms, one LiDAR tile ([\d.]+) ms, "
                          r"one submap moved ([\d.]+) ms", text or "")
        if not found:
            continue
        m2, tiles, whole, camera, lidar, moved = map(float, found.groups())
        for name, cost in zip(curves, (camera, lidar, moved, whole)):
            curves[name].append((m2, cost))
        memory.append((m2, mb))
        rows.append((f"{m2:.0f}", f"{tiles:.0f}", f"{camera:.2f}", f"{lidar:.2f}", f"{moved:.2f}", f"{whole:.0f}", f"{mb:.0f}"))
    rows.append(("growth", "", *(growth(c) for c in curves.values()), growth(memory)))
    bench.table("Scale: area of the fused map", "area_bench SIDE_m",
                ["m2", "tiles", "camera tile, ms", "LiDAR tile, ms", "submap moved, ms", "all at once, ms", "memory, MB"], rows,
                end_of_one_machine({"all at once": curves["all at once"]}, {"the map": memory}))
    bench.picture("scale-area.svg", svg("Cost against area", "m2", "ms", curves))


def end_of_one_machine(times, memories):
    """Where a curve, carried on, crosses what one machine has; the parts that stay flat have no end."""
    found = []
    for limit, curves, unit in ((REAL_TIME_MS, times, "ms"), (MACHINE_MB, memories, "MB")):
        for name, points in curves.items():
            k = exponent(points)
            if k and k > 0.12:
                n, cost = points[-1]
                found.append(f"{name} reaches {limit:g} {unit} at about {n * (limit / cost) ** (1 / k):.2g}")
    return ("Carried on, " + "; ".join(found)) if found else ""


def robots(bench, most):
    """Sessions of several robots in one building, joined one after the other."""
    joined, time_s, memory, rows = None, [], [], []
    for robot in range(1, most + 1):
        log, out, saved = (bench.out / f"robot_{robot}{suffix}" for suffix in (".lcm", "", "_map"))
        steps = [("simulate", "config/worlds/office.yaml", "--seed", 40 + robot, "--random-route", "--seconds", 30, "--camera-hz", 5, "--out", log),
                 ("run", log, "--out", out), ("map", "save", out, saved)]
        if not all(bench.call(*step) is not None for step in steps):
            return
        if joined is None:
            joined = saved
            continue
        merged = bench.out / f"robots_{robot}_map"
        started = bench.clock()
        text, mb = bench.measured("map", "merge", joined, saved, merged)
        if text is None:
            rows.append((robot, "no overlap proven", "-"))
            continue
        joined = merged
        time_s.append((robot, bench.clock() - started))
        memory.append((robot, mb))
        rows.append((robot, f"{time_s[-1][1]:.1f}", f"{mb:.0f}"))
    rows.append(("growth", growth(time_s), growth(memory)))
    bench.table("Scale: robots", "map merge A B OUT", ["robots", "joining one more, s", "memory, MB"], rows,
                "Each robot drove 30 s through the same office by a way of its own; the sessions are joined one by one")

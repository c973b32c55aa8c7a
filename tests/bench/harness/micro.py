"""Routines and libraries, without a bus."""

import json
import re


def duration(value, unit):
    units = ["ns", "us", "ms", "s"]
    while value >= 1000 and unit != "s":
        value, unit = value / 1000, units[units.index(unit) + 1]
    return f"{value:.3g} {unit}"


def routines(bench):
    text = bench.call("micro_bench", "--benchmark_format=json", "--benchmark_min_time=0.05")
    if text is None:
        return
    found = json.loads(text[text.index("{"):text.rindex("}") + 1])["benchmarks"]
    rows = [(b["name"].replace("_", " "), duration(b["cpu_time"], b["time_unit"])) for b in found if "cpu_time" in b]
    bench.table("Routines", "micro_bench --benchmark_min_time=0.05", ["routine", "processor time"], rows,
                "Each hot routine beside the slow obvious one that its test compares it with")


def rendering(bench):
    rows = []
    for world in ("office", "corridor", "hall"):
        text = bench.call("render_bench", f"config/worlds/{world}.yaml", "--frames", 20)
        found = re.search(r"([\d.]+) frames/s", text or "")
        rows.append((world, found.group(1) if found else "-"))
    bench.table("Rendering", "render_bench config/worlds/WORLD.yaml --frames 20", ["world", "frames a second of one core"], rows)


def lidar_front_end(bench, seeds):
    rows = []
    for world in ("building", "corridor"):
        for odometry in (True, False):
            for seed in range(1, seeds + 1):
                out = bench.out / f"lidar_{world}_{seed}"
                words = [] if odometry else ["--no-odometry"]
                text = bench.call("lidar_mapper_bench", "rplidar", "--format", world, "--seed", seed, "--out", out, *words)
                score = bench.call("eval", "ape", f"{out}_truth.tum", f"{out}.tum", "--align", "se3")
                ms = re.search(r"median ([\d.]+) ms, p95 ([\d.]+), p99 ([\d.]+)", text or "")
                nees = re.search(r"NEES ([\d.]+)", text or "")
                rmse = re.search(r"rmse\s+([\d.]+)", score or "")
                rows.append((world, "yes" if odometry else "no", seed, rmse.group(1) if rmse else "-",
                             f"{ms.group(1)} / {ms.group(3)}" if ms else "-", nees.group(1) if nees else "-"))
    bench.table("LiDAR mapper, drawn worlds, no closures", "lidar_mapper_bench rplidar --format WORLD --seed N", [
        "world", "odometry", "seed", "APE RMSE, m", "ms a scan, median / p99", "NEES (3 is right)"], rows)


def solver(bench):
    text = bench.call("pose_graph_bench")
    rows = re.findall(r"(\d+) nodes,\s+(\d+) edges: quick solve ([\d.]+) ms.*?from scratch ([\d.]+) ms", text or "")
    bench.table("Pose graph", "pose_graph_bench", ["nodes", "edges", "quick solve, ms", "global solve, ms"], rows)

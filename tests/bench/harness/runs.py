"""Whole runs: all services as processes over UDP multicast."""

import json
import os
import resource

from harness.bench import median, spread

# Before the runs: what counts as a success (issue 11, the paper's Table 5).
MOST_APE_M = 0.10
LEAST_F1 = 0.85
SENSORS = {"fused": [], "camera alone": ["--without", "lidar,odometry"], "LiDAR alone": ["--without", "camera"]}
# Yu et al. 2025, Table 5: their own method, ORB-SLAM2, Cartographer; average time, successful rate.
# A run whose time counts: what other programs may have of the cores meanwhile.
MOST_OTHERS = 0.1
PAPER = {"fused": "315 s, 94 %", "camera alone": "334 s, 78 %", "LiDAR alone": "269 s, 86 %"}


def simulated(bench, world, seed, seconds, camera_hz):
    """A recording and its truth; None when it could not be made."""
    name = f"{world}_{seed}_{seconds}s_{camera_hz}hz"
    log, truth = bench.out / f"{name}.lcm", bench.out / f"{name}_truth"
    if bench.resume and all((bench.out / f"{name}_{sensors.replace(' ', '_')}/metrics.json").exists() for sensors in SENSORS):
        return name, log, truth
    if not log.exists() and bench.call("simulate", f"config/worlds/{world}.yaml", "--seed", seed, "--seconds", seconds,
                                       "--camera-hz", camera_hz, "--out", log, "--truth", truth) is None:
        return None
    return name, log, truth


def run(bench, name, log, *options):
    """metrics.json of one run, and in `others` what share of the machine's cores other programs had meanwhile; None when it did not
    come to its end."""
    out = bench.out / name
    beside = out / "others.json"
    if not (bench.resume and (out / "metrics.json").exists()):
        busy, ours, began = busy_s(), children_s(), bench.clock()
        if bench.call("run", log, "--out", out, "--no-session", *options) is None:
            return None
        others = (busy_s() - busy - (children_s() - ours)) / ((bench.clock() - began) * os.cpu_count())
        beside.write_text(json.dumps(round(others, 3)))
    metrics = json.loads((out / "metrics.json").read_text())
    metrics["others"] = json.loads(beside.read_text()) if beside.exists() else 1.0
    return metrics


def busy_s():
    """Processor seconds that all programs of this machine have had."""
    user, nice, system, _, _, irq, softirq = map(int, open("/proc/stat").readline().split()[1:8])
    return (user + nice + system + irq + softirq) / os.sysconf("SC_CLK_TCK")


def children_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def map_score(bench, name, truth, grid="map"):
    out = bench.out / name
    score = bench.out / f"{name}_{grid}_score.json"
    if bench.call("eval", "map", truth / "map.yaml", out / f"{grid}.yaml", "--align", out / "groundtruth.tum",
                  out / "trajectory.tum", "--classes", truth / "classes.pgm", "--json", score) is None:
        return None
    return json.loads(score.read_text())


def pace(bench, seconds, camera_hz):
    """Speed and losses of the whole system on the office."""
    made = simulated(bench, "office", 1, seconds, camera_hz)
    if made is None:
        return
    name, log, truth = made
    rows = []
    for mode in ("lockstep", "throughput"):
        m = run(bench, f"{name}_{mode}", log, "--mode", mode)
        if m is None:
            rows.append((mode, "failed") + ("-",) * 6)
            continue
        f1 = map_score(bench, f"{name}_{mode}", truth)
        memory = sum(p["peak_rss_bytes"] for p in m["processes"].values()) / 1e6
        processor = sum(p["cpu_s"] for p in m["processes"].values())
        rows.append((mode, f"{m['real_time_factor']:.2f}", f"{m.get('ape_rmse_m', float('nan')):.4f}",
                     f"{m['coverage_percent']:.1f}", f"{f1['f1']:.3f}" if f1 else "-",
                     f"{m['dropped_total']}, {m['lost_total']}", f"{processor:.0f}", f"{memory:.0f}"))
    bench.table(f"Office, {seconds} s, camera {camera_hz} Hz, all services", "run LOG --mode MODE",
                ["mode", "x real time", "APE RMSE, m", "coverage, %", "fused F1", "dropped, lost", "processor, s", "memory, MB"], rows)


def is_success(m, score):
    return bool(m and score) and m.get("ape_rmse_m", MOST_APE_M) < MOST_APE_M and score["f1"] > LEAST_F1


def success(bench, worlds, seeds, seconds, camera_hz):
    """The paper's Table 5: building time and success rate of each sensor and both."""
    scored, of_world = {sensors: [] for sensors in SENSORS}, {}
    for seed in range(1, seeds + 1):
        for world in worlds:
            made = simulated(bench, world, seed, seconds, camera_hz)
            if made is None:
                continue
            for sensors, options in SENSORS.items():
                name = f"{made[0]}_{sensors.replace(' ', '_')}"
                m = run(bench, name, made[1], *options)
                score = map_score(bench, name, made[2]) if m else None
                scored[sensors].append((m, score))
                of_world.setdefault((sensors, world), []).append(is_success(m, score))
                if m is not None:
                    bench.found.setdefault((world, sensors), []).append(m)
            made[1].unlink(missing_ok=True)  # fifty of them would fill the disk
    rows = []
    for sensors, results in scored.items():
        whole = [(m, score) for m, score in results if m and score and "ape_rmse_m" in m]
        good = sum(is_success(m, score) for m, score in results)
        by_world = ", ".join(f"{world} {sum(of_world[sensors, world])}" for world in worlds if (sensors, world) in of_world)
        alone = [m["wall_s"] for m, _ in whole if m["others"] <= MOST_OTHERS]
        processor = [sum(p["cpu_s"] for p in m["processes"].values()) for m, _ in whole]
        rows.append((sensors, f"{good} of {len(results)} ({by_world})", spread([m["ape_rmse_m"] for m, _ in whole], 4),
                     spread([score["f1"] for _, score in whole]), spread(alone, 0), spread(processor, 0), PAPER[sensors]))
    bench.table(f"Table 5: {', '.join(worlds)}, {seconds} s, {seeds} seeds each", "run LOG [--without SENSORS]", [
        "sensors", "successes", "APE RMSE, m", "occupied F1", "building time, s", "processor, s", "paper"], rows,
        f"Success: the run completes, APE < {MOST_APE_M} m, occupied F1 > {LEAST_F1}. Building time: of the runs that had the machine to themselves")


def recordings(bench, shared, repeats):
    """Real recordings, where they are."""
    lidar, rgbd = shared / "data/lidar", shared / "data/rgbd"
    sources = {
        "7scenes-redkitchen": ["7scenes", rgbd / "7scenes-redkitchen/data"],
        "mit-csail": ["carmen", lidar / "mit-csail-clf/mit-csail.clf", "--ground-truth",
                      lidar / "mit-csail-clf/mit-csail_reference_gmapping_406.tum"],
        "fr079": ["carmen", lidar / "fr079/freiburg-079-corrected.log.gz"],
        "maebot": ["rplidar-lcm", lidar / "lcm-maebot-empty/empty_environment.log"],
    }
    rows = []
    for name, (form, source, *more) in sources.items():
        if not source.exists():
            rows.append((name, f"skipped: recording {source} not found") + ("-",) * 5)
            continue
        log = bench.out / f"{name}.lcm"
        if bench.call("import", form, source, log, *more) is None:
            continue
        options = ["--relations", lidar / "fr079/fr079.relations", "--time-offset", 1211.36] if name == "fr079" else []
        found = [m for k in range(repeats) if (m := run(bench, f"{name}_{k}", log, *options))]
        of = lambda key: [m[key] for m in found if key in m]
        rows.append((name, f"{len(found)} of {repeats}", spread(of("ape_rmse_m"), 4), spread(of("rpe_rmse_m"), 4),
                     spread(of("relations_translation_mean_m"), 4), spread(of("coverage_percent"), 1),
                     spread(of("real_time_factor"), 1)))
    bench.table("Real recordings", "import ...; run LOG", [
        "recording", "runs", "APE RMSE, m", "RPE RMSE, m", "relations, m", "coverage, %", "x real time"], rows)

"""The tables of the paper (Yu et al. 2025), each beside its own figures."""

import math
import pathlib
import re

from harness import runs
from harness.bench import median, spread

# Tables 2 and 3: RMSE and STD of ORB-SLAM2 and of the paper's method, m.
PAPER_APE = {"fr1_xyz": "0.0898 0.0546, 0.0106 0.0035", "fr1_floor": "0.1642 0.0736, 0.0250 0.0102",
             "fr1_room": "0.0675 0.0315, 0.0785 0.0389", "fr2_desk": "0.1025 0.0458, 0.0256 0.0058",
             "fr2_rpy": "0.0252 0.0425, 0.0158 0.0358"}
PAPER_RPE = {"fr1_xyz": "0.0608 0.0347, 0.0061 0.0034", "fr1_floor": "0.0437 0.0286, 0.0181 0.0177",
             "fr1_room": "0.1196 0.0856, 0.1363 0.0952", "fr2_desk": "0.0458 0.0256, 0.0158 0.0185",
             "fr2_rpy": "0.0635 0.0958, 0.0725 0.1085"}
# Table 4: tracking, ms a frame, ORB-SLAM2 and the paper's method; and section 4.2.1's lengths.
PAPER_TRACKING = "mean 65.69, 66.38; median 66.78, 67.25"
PAPER_LENGTHS = "3.065 m of ORB-SLAM2, 3.656 m of the paper's method"


def errors(bench):
    """Tables 2 and 3 from the runs that Table 5 made: the camera alone, and with all that is ours."""
    for title, rmse, std in (("Table 2: absolute pose error, m", "ape_rmse_m", "ape_std_m"),
                             ("Table 3: relative pose error from frame to frame, m", "rpe_rmse_m", "rpe_std_m")):
        rows = []
        for world in sorted({key[0] for key in bench.found}):
            of = lambda sensors, what: [m[what] for m in bench.found.get((world, sensors), []) if what in m]
            alone, both = median(of("camera alone", rmse)), median(of("fused", rmse))
            rows.append((world, spread(of("camera alone", rmse), 4), f"{median(of('camera alone', std)):.4f}",
                         spread(of("fused", rmse), 4), f"{median(of('fused', std)):.4f}", f"{100 * (1 - both / alone):.0f} %"))
        bench.table(title, "run LOG [--without lidar,odometry]",
                    ["sequences", "camera alone, RMSE", "STD", "both sensors, RMSE", "STD", "improvement of RMSE"], rows,
                    "The paper's sequences need TUM's recordings: `fusion-slam bench tum DIR` sets its figures beside ours")


def length_m(trajectory):
    """Of a TUM file's path, and of those parts of it that follow without a gap of more than half a second."""
    poses = [[float(v) for v in line.split()[:4]] for line in pathlib.Path(trajectory).read_text().splitlines() if line and line[0] != "#"]
    steps = [math.dist(a[1:], b[1:]) for a, b in zip(poses, poses[1:]) if b[0] - a[0] < 0.5]
    return sum(steps)


def few_features(bench, seconds):
    """How far the camera is followed where there is little to see (section 4.2.1)."""
    made = runs.simulated(bench, "corridor", 1, seconds, 15)
    if made is None:
        return
    name, log, _ = made
    rows = []
    for features in (1000, 250, 100, 50):
        row, truth = [features], 0.0
        for words in (["--no-lidar-depth", "--no-lidar-motion", "--no-surfaces"], ["--lidar-mapper"]):
            out, reference = bench.out / f"{name}_few.tum", bench.out / f"{name}_few_truth.tum"
            text = bench.call("visual_odometry_bench", log, "--features", features, "--out", out, "--reference", reference, *words)
            covered = re.search(r"\| ([\d.]+) % \|", text or "")
            if not covered:
                row.append("failed")
                continue
            truth = length_m(reference)
            row.append(f"{length_m(out):.1f} m, {covered.group(1)} % of the frames")
        rows.append((*row, f"{truth:.1f} m"))
    bench.table(f"Trajectory under few features: corridor, {seconds} s", "visual_odometry_bench LOG --features N",
                ["features a frame", "vision as it is without ours", "with depth, LiDAR and surfaces", "truth"], rows, f"The paper: {PAPER_LENGTHS}")


def tracking(bench, logs):
    """Table 4: one core, the tracking thread."""
    rows = []
    for name, log in logs:
        text = bench.call("visual_odometry_bench", log)
        found = re.search(r"CPU ms a frame \(tracking thread\): mean ([\d.]+) median ([\d.]+) p95 ([\d.]+) p99 ([\d.]+)", text or "")
        rows.append((name, *(found.groups() if found else "----")))
    bench.table("Table 4: tracking a frame, ms of processor time", "visual_odometry_bench LOG",
                ["recording", "mean", "median", "p95", "p99"], rows, f"The paper, on its own computer, on fr1_xyz: {PAPER_TRACKING}")


def sequence_name(folder):
    """fr1_xyz of rgbd_dataset_freiburg1_xyz."""
    found = re.search(r"(?:freiburg|fr)(\d)[_-](\w+)", folder.name)
    return f"fr{found.group(1)}_{found.group(2)}" if found else folder.name


def tum(bench, directory, repeats):
    """Each TUM RGB-D sequence below a directory (those with rgb.txt), or the directory itself."""
    folders = sorted({p.parent for p in [*directory.glob("rgb.txt"), *directory.glob("*/rgb.txt")]})
    rows = {"ape": [], "rpe": []}
    for folder in folders:
        name, log = sequence_name(folder), bench.out / f"{folder.name}.lcm"
        if bench.call("import", "tum", folder, log) is None:
            continue
        found = [m for k in range(repeats) if (m := runs.run(bench, f"{folder.name}_{k}", log))]
        for kind, paper in (("ape", PAPER_APE), ("rpe", PAPER_RPE)):
            of = lambda what: [m[f"{kind}_{what}_m"] for m in found if f"{kind}_{what}_m" in m]
            rows[kind].append((name, f"{len(found)} of {repeats}", found[0]["camera_frames"] if found else "-", spread([m["coverage_percent"] for m in found], 1), spread(of("rmse"), 4),
                               spread(of("std"), 4), paper.get(name, "-")))
    for kind, title in (("ape", "Table 2: absolute pose error"), ("rpe", "Table 3: relative pose error from frame to frame")):
        bench.table(f"{title}, m", f"fusion-slam bench tum {directory}",
                    ["sequence", "runs", "frames", "coverage, %", "RMSE", "STD", "paper: ORB-SLAM2 RMSE STD, its own RMSE STD"], rows[kind])
    return len(folders)

#!/usr/bin/env python3
"""How well `calibrate extrinsics` finds mountings, over simulated drives whose truth is known.

    tests/bench/calibration/seeds.py [--programs build/release/bin] [--seeds 10] [--seconds 60] [--out DIR]

Each seed puts both sensors up to 5 cm, 3 degrees and the camera's clock up to 50 ms away from what
ROBOT_MODEL says, drives through the office by a route of its own, and compares. Standard library only.
"""
import argparse, math, os, random, re, subprocess

BARS = {"m": 0.005, "deg": 0.2, "ms": 5.0}


def mount(text, key):
    found = re.search(key + r": \[(.*)\]", text)
    return [float(v) for v in found.group(1).split(",")] if found else None


def errors(report, lidar, camera, late_ms):
    got_lidar, got_camera = mount(report, "lidar_mount_xyz_m_rpy_deg"), mount(report, "camera_mount_xyz_m_rpy_deg")
    offset = re.search(r"stamp_offset_ms: (.*)", report)
    if not got_lidar or not got_camera or not offset:
        return None
    rows = [("lidar " + n, got_lidar[i] - lidar[i], u) for n, i, u in (("x", 0, "m"), ("y", 1, "m"), ("yaw", 5, "deg"))]
    rows += [("camera " + n, got_camera[i] - camera[i], u)
             for n, i, u in (("x", 0, "m"), ("y", 1, "m"), ("height", 2, "m"), ("roll", 3, "deg"), ("pitch", 4, "deg"), ("yaw", 5, "deg"))]
    return rows + [("time", float(offset.group(1)) + late_ms, "ms")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", default="build/release/bin")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--world", default="config/worlds/office.yaml")
    parser.add_argument("--out", default="/tmp/calibration")
    a = parser.parse_args()
    os.makedirs(a.out, exist_ok=True)
    table = {}
    for seed in range(a.first, a.first + a.seeds):
        rng = random.Random(seed)
        off = lambda v, most: v + rng.uniform(-most, most)
        lidar = [off(0, .05), off(0, .05), 0.20, 0, 0, off(0, 3)]
        camera = [off(.10, .05), off(0, .05), off(.35, .03), off(0, 2), off(0, 3), off(0, 3)]
        late_ms = off(0, 50)
        log = os.path.join(a.out, "seed%d.lcm" % seed)
        numbers = lambda values: ",".join("%.5f" % v for v in values)
        subprocess.run([a.programs + "/simulate", a.world, "--seed", str(seed), "--seconds", str(a.seconds), "--camera-hz", "4",
                        "--random-route", "--lidar-at=" + numbers(lidar), "--camera-at=" + numbers(camera),
                        "--camera-late-ms", "%.3f" % late_ms, "--out", log], check=True, capture_output=True)
        report = subprocess.run([a.programs + "/calibrate", "extrinsics", log], check=True, capture_output=True, text=True).stdout
        open(os.path.join(a.out, "seed%d.txt" % seed), "w").write(report)
        os.remove(log)
        rows = errors(report, lidar, camera, late_ms)
        print("seed %d: %s" % (seed, "not found: see its report" if rows is None else
                               "  ".join("%s %+.4f" % (n, e) for n, e, u in rows)), flush=True)
        for name, error, unit in rows or []:
            table.setdefault((name, unit), []).append(error)
    print("\n| | bar | mean | rms | worst | within the bar |\n|---|---|---|---|---|---|")
    for (name, unit), e in table.items():
        n = len(e)
        print("| %s, %s | %g | %+.4f | %.4f | %.4f | %d of %d |" % (
            name, unit, BARS[unit], sum(e) / n, math.sqrt(sum(x * x for x in e) / n), max(map(abs, e)),
            sum(abs(x) <= BARS[unit] for x in e), n))


if __name__ == "__main__":
    main()

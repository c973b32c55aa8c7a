"""What every measurement shares: the programs, the machine, the results and their tables."""

import datetime
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

# Runs a program and notes the peak of its memory, which only its parent can ask for.
MEASURE = ("import resource, subprocess, sys; code = subprocess.call(sys.argv[2:]); "
           "open(sys.argv[1], 'w').write(str(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)); sys.exit(code)")
ROOT = pathlib.Path(__file__).resolve().parents[3]


def machine():
    """Names what a figure depends on: commit, processor, load."""
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    dirty = subprocess.run(["git", "-C", ROOT, "status", "--porcelain", "-uno"], capture_output=True, text=True)
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    return {
        "commit": commit.stdout.strip() + ("+changes" if dirty.stdout.strip() else ""),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "cpu": cpu,
        "cores": os.cpu_count(),
        "load": round(os.getloadavg()[0], 1),
        "system": platform.platform(),
    }


def median(values):
    return statistics.median(values) if values else float("nan")


def spread(values, digits=3):
    """Median, and least to most when there are several."""
    if not values:
        return "-"
    text = f"{median(values):.{digits}f}"
    return text if len(values) == 1 else f"{text} ({min(values):.{digits}f} - {max(values):.{digits}f}, n {len(values)})"


class Bench:
    """Runs programs of one build and collects tables; a failed command is a result, too."""

    def __init__(self, build, out, resume=False):
        self.bin = pathlib.Path(build).resolve() / "bin"
        self.out = pathlib.Path(out).resolve()
        self.out.mkdir(parents=True, exist_ok=True)
        self.resume = resume  # runs whose metrics.json is there are not made again
        self.tables = []
        self.failures = []
        self.pictures = []
        self.found = {}  # the metrics of runs that several tables need: (world, sensors) -> [metrics]
        if not self.bin.is_dir():
            sys.exit(f"{self.bin}: not there; build with tests first (./fusion-slam test --quick)")

    def call(self, program, *arguments, timeout_s=3600):
        """Standard output of a program; None, and the failure noted, when it fails."""
        command = [str(self.bin / program), *map(str, arguments)]
        started = time.monotonic()
        print(f"  {program} {' '.join(map(str, arguments))}", file=sys.stderr, flush=True)
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=timeout_s, cwd=ROOT)
        except (OSError, subprocess.TimeoutExpired) as error:
            self.failures.append({"command": command, "why": str(error)})
            return None
        print(f"    {time.monotonic() - started:.1f} s", file=sys.stderr, flush=True)
        if done.returncode == 0:
            return done.stdout + done.stderr
        self.failures.append({"command": command, "why": f"exit code {done.returncode}: {done.stderr[-2000:]}"})
        return None

    def measured(self, program, *arguments):
        """Standard output and the most memory the program had, MB; None, 0 when it failed."""
        with tempfile.NamedTemporaryFile() as note:
            command = ["/usr/bin/env", "python3", "-c", MEASURE, note.name, str(self.bin / program), *map(str, arguments)]
            print(f"  {program} {' '.join(map(str, arguments))}", file=sys.stderr, flush=True)
            done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
            if done.returncode != 0:
                self.failures.append({"command": [program, *map(str, arguments)], "why": f"exit code {done.returncode}: {done.stderr[-2000:]}"})
                return None, 0.0
            return done.stdout + done.stderr, float(note.read()) / 1e3

    def clock(self):
        return time.monotonic()

    def picture(self, name, svg):
        """Kept beside the tables; with --write also in docs/images."""
        (self.out / name).write_text(svg)
        self.pictures.append(name)

    def table(self, title, command, head, rows, note=""):
        self.tables.append({"title": title, "command": command, "head": head, "rows": rows, "note": note})

    def markdown(self):
        about = machine()
        lines = [
            f"Commit {about['commit']}, {about['date']}, {about['cpu']}, {about['cores']} cores, load {about['load']} at the end.",
            "Median (least - most, n runs) where there were several.", ""]
        for t in self.tables:
            lines += [f"### {t['title']}", f"`{t['command']}`" + (f". {t['note']}" if t["note"] else ""), "",
                      "| " + " | ".join(t["head"]) + " |", "|" + "---|" * len(t["head"])]
            lines += ["| " + " | ".join(map(str, row)) + " |" for row in t["rows"]]
            lines.append("")
        lines += [f"![{name}](images/{name})\n" for name in self.pictures]
        lines += [f"Failed: `{' '.join(map(str, f['command']))}`: {f['why']}" for f in self.failures]
        return "\n".join(lines).rstrip() + "\n"

    def write(self):
        results = {"machine": machine(), "tables": self.tables, "failures": self.failures}
        (self.out / "results.json").write_text(json.dumps(results, indent=2) + "\n")
        (self.out / "results.md").write_text(self.markdown())

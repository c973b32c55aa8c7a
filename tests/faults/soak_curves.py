#!/usr/bin/env python3
"""What a soak measured, as curves and as a table.

    tests/faults/soak_curves.py OUT [--svg FILE] [--minutes 10,30,60,90,119]

OUT is what tests/faults/soak was given as --out, while it runs or afterwards. Prints, for people and for
docs/faults.md, each service's memory and latency (medians of the 4 minutes around each of --minutes) and how long
it took to be back at work after each kill; draws the curves."""
import argparse, csv, os, statistics, sys

sys.dont_write_bytecode = True
import curves

HALF_WINDOW_MIN = 2.0
MEMORY, LATENCY, WAITING = "rss_mb", "latency_ms_p95", "queue"


def read(folder):
    """The lines of curves.csv and of restarts.csv, as dictionaries with numbers; a half-written last line is left out."""
    def lines(name):
        with open(os.path.join(folder, name)) as file:
            text = file.read()
        for line in csv.DictReader(text[:text.rfind("\n") + 1].splitlines()):
            yield {k: v if k == "service" else float(v) for k, v in line.items()}
    return list(lines("curves.csv")), list(lines("restarts.csv"))


def services(rows):
    return list(dict.fromkeys(r["service"] for r in rows))


def at_work(row):
    """It was neither dead nor just begun."""
    return row[MEMORY] > 0 and row[LATENCY] > 0


def draw(path, rows, restarts):
    def series(lines, column):
        return {s: [(r["minute"], r[column]) for r in lines if r["service"] == s] for s in services(rows)}
    alive = [r for r in rows if at_work(r)]
    curves.write(path, [("memory (MB)", series(alive, MEMORY), False),
                        ("latency, 95 of 100 messages (ms)", series(alive, LATENCY), True),
                        ("messages waiting", series(rows, WAITING), False),
                        ("killed, back at work after (s)", series(restarts, "back_after_s"), False)],
                 sorted({r["minute"] for r in rows if r["restarted"]}))


def around(rows, service, column, minute):
    values = [r[column] for r in rows if r["service"] == service and abs(r["minute"] - minute) <= HALF_WINDOW_MIN
              and at_work(r)]
    return statistics.median(values) if values else float("nan")


def table(rows, restarts, minutes):
    def line(name, cells):
        return "| " + " | ".join([name] + cells) + " |"
    head = [f"{m:g}" for m in minutes]
    for title, column in (("memory, MB, at minute", MEMORY), ("latency, ms, at minute", LATENCY)):
        yield line(title, head)
        yield "|---" * (len(minutes) + 1) + "|"
        together = [0.0] * len(minutes)
        for service in services(rows):
            values = [around(rows, service, column, m) for m in minutes]
            together = [a + b for a, b in zip(together, values)]
            yield line(service, [f"{v:.0f}" for v in values])
        if column == MEMORY:
            yield line("together", [f"{v:.0f}" for v in together])
        yield ""
    yield "| killed | times | back after: median, slowest (s) | slowest at minute |"
    yield "|---|---|---|---|"
    for service in services(rows):
        back = sorted((r["back_after_s"], r["minute"]) for r in restarts if r["service"] == service)
        if back:
            yield line(service, [str(len(back)), f"{statistics.median(b for b, _ in back):.1f}, {back[-1][0]:.1f}",
                                 f"{back[-1][1]:.0f}"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("out", help="folder that tests/faults/soak wrote into")
    parser.add_argument("--svg", help="draw the curves into this file")
    parser.add_argument("--minutes", default="10,30,60,90,119")
    a = parser.parse_args()
    try:
        rows, restarts = read(a.out)
    except (OSError, ValueError, TypeError) as error:
        sys.exit(f"no curves of a soak in {a.out}: {error}")
    if a.svg:
        draw(a.svg, rows, restarts)
    print("\n".join(table(rows, restarts, [float(m) for m in a.minutes.split(",")])))
    return 0


if __name__ == "__main__":
    sys.exit(main())

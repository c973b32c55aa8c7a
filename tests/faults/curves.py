"""Curves over time as SVG, for tests/faults/soak_curves.py."""
import math

COLOURS = ["#1b6ca8", "#d1495b", "#2e8b57", "#b8860b", "#6a4c93", "#444444"]
WIDTH, HEIGHT, LEFT, TOP, STEP = 900, 260, 70, 40, 330


def nice(top):
    """The smallest 1, 2 or 5 times a power of ten that is not below."""
    scale = 1.0
    while scale < top:
        scale *= 10.0
    while scale / 10.0 >= top:
        scale /= 10.0
    return next(f * scale for f in (0.1, 0.2, 0.5, 1.0) if f * scale >= top)


def panel(out, row, title, series, logarithmic, ticks, minutes):
    """series: name -> [(minute, value)]; ticks: minutes of restarts. Logarithmic: from 1 on, less is drawn as 1."""
    y0 = TOP + row * STEP
    highest = max([v for points in series.values() for _, v in points] + [1e-3])
    decades = max(1, math.ceil(math.log10(max(highest, 10.0))))
    top = nice(highest)

    def x(m):
        return LEFT + m / minutes * WIDTH

    def y(v):
        share = math.log10(max(v, 1.0)) / decades if logarithmic else v / top
        return y0 + HEIGHT * (1.0 - share)
    out.append(f'<text x="{LEFT}" y="{y0 - 10}" font-weight="bold">{title}</text>')
    for m in ticks:
        out.append(f'<line x1="{x(m):.1f}" x2="{x(m):.1f}" y1="{y0}" y2="{y0 + HEIGHT}" stroke="#e4e4e4"/>')
    for v in [10.0**k for k in range(decades + 1)] if logarithmic else [top * k / 5 for k in range(6)]:
        out.append(f'<line x1="{LEFT}" x2="{LEFT + WIDTH}" y1="{y(v):.1f}" y2="{y(v):.1f}" stroke="#bbb"/>'
                   f'<text x="{LEFT - 8}" y="{y(v) + 4:.1f}" text-anchor="end">{v:g}</text>')
    step = next(d for d in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if minutes / d <= 8 or d == 1000)
    for m in range(0, int(minutes) + 1, step):
        out.append(f'<text x="{x(m):.1f}" y="{y0 + HEIGHT + 18}" text-anchor="middle">{m}</text>')
    for i, (name, points) in enumerate(series.items()):
        colour = COLOURS[i % len(COLOURS)]
        path = " ".join(f"{x(m):.1f},{y(v):.1f}" for m, v in points)
        if len(points) > 1:
            out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        if len(points) < 40:
            out.extend(f'<circle cx="{x(m):.1f}" cy="{y(v):.1f}" r="3" fill="{colour}"/>' for m, v in points)
        out.append(f'<text x="{LEFT + WIDTH + 10}" y="{y0 + 14 + 18 * i}" fill="{colour}">{name}</text>')


def write(path, panels, ticks):
    """panels: (title, series, logarithmic) from top to bottom, over minutes; ticks: when something was done."""
    minutes = max([m for _, series, _ in panels for points in series.values() for m, _ in points] + [1e-3])
    out = []
    for row, (title, series, logarithmic) in enumerate(panels):
        panel(out, row, title, series, logarithmic, ticks, minutes)
    height = TOP + STEP * len(panels)
    out.append(f'<text x="{LEFT}" y="{height - 8}">minutes; grey: a restart</text>')
    with open(path, "w") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{LEFT + WIDTH + 170}" height="{height + 10}" '
                   'font-family="DejaVu Sans, sans-serif" font-size="12"><rect width="100%" height="100%" '
                   'fill="white"/>' + "\n".join(out) + "</svg>\n")

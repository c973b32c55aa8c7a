"""Curves of cost against size: how they grow, and a picture (SVG, both axes logarithmic)."""

import math

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9"]  # Okabe and Ito: told apart by the colour-blind, too


def exponent(points):
    """The k of cost ~ size^k, least squares over the larger half of the points; None for fewer than two."""
    points = [(math.log(x), math.log(y)) for x, y in points if x > 0 and y > 0]
    points = points[len(points) // 2 if len(points) > 2 else 0:]
    if len(points) < 2:
        return None
    mx = sum(x for x, _ in points) / len(points)
    my = sum(y for _, y in points) / len(points)
    spread = sum((x - mx) ** 2 for x, _ in points)
    return sum((x - mx) * (y - my) for x, y in points) / spread if spread else None


def growth(points):
    """In words. A logarithm looks like a small power over a few decades, n log n like one a little above 1."""
    k = exponent(points)
    if k is None:
        return "-"
    for limit, name in ((0.12, "constant"), (0.4, "like log n"), (0.85, "less than n"), (1.1, "like n"), (1.35, "like n log n")):
        if k < limit:
            return f"{name} (n^{k:.2f})"
    return f"n^{k:.2f}"


def ticks(low, high):
    return [10.0 ** e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)]


def number(value):
    return f"{value:g}" if value < 10000 else f"10^{round(math.log10(value))}"


def svg(title, size, unit, curves):
    """curves: {name: [(size, cost), ...]}, all of one unit."""
    points = [p for curve in curves.values() for p in curve if p[0] > 0 and p[1] > 0]
    xs, ys = ticks(min(x for x, _ in points), max(x for x, _ in points)), ticks(min(y for _, y in points), max(y for _, y in points))
    left, top, width, height = 70, 46, 520, 300

    def at(x, y):
        u = math.log(x / xs[0]) / max(1e-9, math.log(xs[-1] / xs[0]))
        v = math.log(y / ys[0]) / max(1e-9, math.log(ys[-1] / ys[0]))
        return left + u * width, top + (1 - v) * height

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left + width + 30} {top + height + 60 + 18 * len(curves)}" '
           'font-family="sans-serif" font-size="13"><rect width="100%" height="100%" fill="#fff"/>',
           f'<text x="{left}" y="24" font-size="16">{title}</text>']
    for x in xs:
        px, _ = at(x, ys[0])
        out.append(f'<path d="M{px:.1f} {top}v{height}" stroke="#ddd"/><text x="{px:.1f}" y="{top + height + 18}" text-anchor="middle">{number(x)}</text>')
    for y in ys:
        _, py = at(xs[0], y)
        out.append(f'<path d="M{left} {py:.1f}h{width}" stroke="#ddd"/><text x="{left - 8}" y="{py + 4:.1f}" text-anchor="end">{number(y)}</text>')
    out.append(f'<text x="{left + width / 2}" y="{top + height + 38}" text-anchor="middle">{size}</text>')
    out.append(f'<text x="16" y="{top - 8}">{unit}</text>')
    for i, (name, curve) in enumerate(curves.items()):
        colour = COLOURS[i % len(COLOURS)]
        places = [at(x, y) for x, y in curve if x > 0 and y > 0]
        out.append(f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in places)}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>' for x, y in places]
        y = top + height + 58 + 18 * i
        out.append(f'<path d="M{left} {y - 4}h24" stroke="{colour}" stroke-width="3"/><text x="{left + 32}" y="{y}">{name}: {growth(curve)}</text>')
    return "\n".join(out) + "\n</svg>\n"

"""A flame graph (Gregg 2016): the stacks of all samples, merged from the outermost function on. Width is the share of samples."""

from xml.sax.saxutils import escape

WIDTH, ROW, LEAST = 1200.0, 18, 0.6  # px; narrower boxes are left out


def merge(folded):
    root = {"n": 0, "in": {}}
    for stack, n in sorted(folded.items()):
        root["n"] += n
        at = root
        for name in stack:
            at = at["in"].setdefault(name, {"n": 0, "in": {}})
            at["n"] += n
    return root


def colour(name, depth):
    # Warm colours, the same for a name wherever it is; services (depth 0) are grey.
    if depth == 0:
        return "#c9ccd1"
    seed = sum(ord(c) * (i + 1) for i, c in enumerate(name))
    return f"hsl({20 + seed % 36},{70 + seed % 20}%,{62 + seed % 12}%)"


def flame_svg(title, folded):
    root = merge(folded)
    boxes, deepest = [], 0

    def draw(name, node, x, depth):
        nonlocal deepest
        width = WIDTH * node["n"] / root["n"]
        if width < LEAST:
            return
        deepest = max(deepest, depth)
        share = f"{name}: {100 * node['n'] / root['n']:.1f} %"
        letters = int(width / 6.6)
        text = name if len(name) <= letters else (name[:letters - 1] + "…" if letters > 4 else "")
        y = depth * ROW
        boxes.append(f'<g><title>{escape(share)}</title><rect x="{x:.1f}" y="{y}" width="{width - 0.4:.1f}" height="{ROW - 1}" '
                     f'fill="{colour(name, depth)}"/>' + (f'<text x="{x + 3:.1f}" y="{y + 13}">{escape(text)}</text>' if text else "") + "</g>")
        for child, below in sorted(node["in"].items(), key=lambda item: -item[1]["n"]):
            draw(child, below, x, depth + 1)
            x += WIDTH * below["n"] / root["n"]

    x = 0.0
    for name, node in sorted(root["in"].items(), key=lambda item: -item[1]["n"]):
        draw(name, node, x, 0)
        x += WIDTH * node["n"] / root["n"]
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-10 -40 {WIDTH + 20:.0f} {(deepest + 1) * ROW + 50}" font-family="sans-serif" '
            f'font-size="11"><rect x="-10" y="-40" width="100%" height="100%" fill="#fff"/><text x="0" y="-16" font-size="16">{escape(title)}</text>'
            + "\n".join(boxes) + "</svg>\n")

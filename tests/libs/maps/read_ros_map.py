"""Reads map.yaml and its PGM by the documentation of ROS map_server and nav2, independently of
Fusion-SLAM, and prints what a robot would get: `resolution width height`, then for each known cell
`x y value` (its centre in metres; 0 free, 100 occupied)."""
import os
import re
import sys


def read_yaml(path):
    values = {}
    for line in open(path):
        key, _, value = line.partition(":")
        values[key.strip()] = value.strip()
    return values


def read_pgm(path):
    data = open(path, "rb").read()
    header = re.match(rb"P5\s(?:#[^\n]*\n)*(\d+)\s+(\d+)\s+(\d+)\s", data)
    width, height, largest = (int(n) for n in header.groups())
    assert largest == 255, largest
    pixels = data[header.end():]
    assert len(pixels) == width * height, (len(pixels), width, height)
    return width, height, pixels


yaml = read_yaml(sys.argv[1])
width, height, pixels = read_pgm(os.path.join(os.path.dirname(sys.argv[1]), yaml["image"]))
resolution = float(yaml["resolution"])
origin = [float(n) for n in yaml["origin"].strip("[]").split(",")]
assert origin[2] == 0.0
negate, occupied, free = int(yaml["negate"]), float(yaml["occupied_thresh"]), float(yaml["free_thresh"])
print(resolution, width, height)
for row in range(height - 1, -1, -1):  # the picture's last row is the map's lowest y
    for column in range(width):
        grey = pixels[row * width + column] / 255.0
        p = grey if negate else 1.0 - grey
        if p > occupied or p < free:
            x = origin[0] + (column + 0.5) * resolution
            y = origin[1] + (height - row - 0.5) * resolution
            print("%.3f %.3f %d" % (x, y, 100 if p > occupied else 0))

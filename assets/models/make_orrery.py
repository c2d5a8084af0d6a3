#!/usr/bin/env python3
"""Writes the clockwork of the demo as OBJ files into this folder: gear wheels, turned parts, rings, stars.

Run it without arguments: `python3 assets/models/make_orrery.py`. It needs Python 3 alone and always writes
the same bytes. All parts have +Y as their axis. Gears have module MODULE (pitch diameter = module * teeth)
and a tooth centred on +X, so that two gears mesh at the sum of their pitch radii.
"""

import math
import random
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
TAU = 2.0 * math.pi
MODULE = 0.03


class Mesh:
    """Corners and faces (counter-clockwise from outside)."""

    def __init__(self):
        self.corners = []
        self.faces = []

    def corner(self, radius, angle, y):
        """A corner at an angle about +Y, counted from +X towards -Z, as a turn about +Y goes."""
        return self.point(radius * math.cos(angle), y, -radius * math.sin(angle))

    def point(self, x, y, z):
        self.corners.append((x, y, z))
        return len(self.corners)

    def strip(self, lower, upper, closed=True):
        """Quads between two rows of corners; outside is to the right of `lower` seen from above."""
        count = len(lower) if closed else len(lower) - 1
        for i in range(count):
            j = (i + 1) % len(lower)
            self.faces.append((lower[i], lower[j], upper[j], upper[i]))

    def write(self, name, what):
        lines = [f"# {what}; made for Orrery by make_orrery.py, CC0"]
        lines += ["v " + " ".join(f"{c:.5f}".rstrip("0").rstrip(".") for c in v) for v in self.corners]
        lines += ["f " + " ".join(map(str, face)) for face in self.faces]
        (FOLDER / name).write_text("\n".join(lines) + "\n")
        triangles = sum(len(face) - 2 for face in self.faces)
        print(f"{name}: {triangles} triangles")


def lathe(mesh, profile, segments):
    """Turns a profile of (radius, y), bottom to top along the outside, about +Y. Radius 0 closes it."""
    rows = []
    for radius, y in profile:
        if radius == 0.0:
            rows.append([mesh.point(0.0, y, 0.0)])
        else:
            rows.append([mesh.corner(radius, TAU * i / segments, y) for i in range(segments)])
    for lower, upper in zip(rows, rows[1:]):
        for i in range(segments):
            j = (i + 1) % segments
            if len(lower) == 1:
                mesh.faces.append((lower[0], upper[j], upper[i]))
            elif len(upper) == 1:
                mesh.faces.append((lower[i], lower[j], upper[0]))
            else:
                mesh.faces.append((lower[i], lower[j], upper[j], upper[i]))


def tube(mesh, profile, segments):
    """Turns a closed profile, counter-clockwise seen with +Y up and the axis to the left."""
    lathe(mesh, profile + profile[:1], segments)


def gear(teeth, spokes):
    """A spoked wheel with trapezoidal teeth, a raised hub and a bevelled rim."""
    mesh = Mesh()
    pitch = MODULE * teeth / 2
    tip, root = pitch + 0.9 * MODULE, pitch - 1.15 * MODULE
    inner = max(root - 0.12, 0.6 * root)
    half = 0.035
    step = TAU / teeth
    # Angles of a tooth's four outline corners, and whether they lie on the tip.
    outline = [(-0.27, False), (-0.12, True), (0.12, True), (0.27, False)]
    rows = {}
    for y in (-half, half):
        rows["out", y], rows["root", y], rows["in", y] = [], [], []
        for i in range(teeth):
            for share, on_tip in outline:
                angle = (i + share) * step
                rows["out", y].append(mesh.corner(tip if on_tip else root, angle, y))
                if not on_tip:
                    rows["root", y].append(rows["out", y][-1])
                    rows["in", y].append(mesh.corner(inner, angle, y))
    mesh.strip(rows["out", -half], rows["out", half])
    mesh.strip(rows["in", half], rows["in", -half])
    mesh.strip(rows["root", half], rows["in", half])
    mesh.strip(rows["in", -half], rows["root", -half])
    for i in range(teeth):
        top = rows["out", half][4 * i : 4 * i + 4]
        bottom = rows["out", -half][4 * i : 4 * i + 4]
        mesh.faces.append((top[0], top[1], top[2], top[3]))
        mesh.faces.append((bottom[3], bottom[2], bottom[1], bottom[0]))
    hub = max(0.1, 0.16 * pitch)
    lathe(mesh, [(0.0, -0.06), (hub, -0.06), (hub + 0.012, -0.048), (hub + 0.012, 0.048), (hub, 0.06), (0.0, 0.06)], 32)
    # Spokes are thinner than the rim, so that no two faces lie in one plane; they taper outwards.
    for i in range(spokes):
        angle = TAU * i / spokes
        along, across = (math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))
        box = []
        for y in (-0.022, 0.022):
            for reach, width in ((0.5 * hub, 0.05), (inner + 0.03, 0.034)):
                for side in (-1, 1):
                    x = along[0] * reach + across[0] * width * side
                    z = along[1] * reach + across[1] * width * side
                    box.append(mesh.point(x, y, z))
        a, b, c, d, e, f, g, h = box
        mesh.faces += [(e, f, h, g), (a, c, d, b), (b, d, h, f), (c, a, e, g), (d, c, g, h), (a, b, f, e)]
    mesh.write(f"gear_{teeth}.obj", f"Gear wheel of {teeth} teeth, module {MODULE}")


def band(name, what, inner, outer, half, segments):
    """A flat ring of rectangular section."""
    mesh = Mesh()
    tube(mesh, [(outer, -half), (outer, half), (inner, half), (inner, -half)], segments)
    mesh.write(name, what)


def torus(name, what, minor, around, across):
    """A torus of major radius 1."""
    mesh = Mesh()
    profile = [(1 + minor * math.cos(TAU * i / across), minor * math.sin(TAU * i / across)) for i in range(across)]
    tube(mesh, profile, around)
    mesh.write(name, what)


def turned(name, what, profile, segments):
    mesh = Mesh()
    lathe(mesh, profile, segments)
    mesh.write(name, what)


def arc(mesh, inner, outer, start, end, y, pieces):
    """A flat piece of a ring, facing up."""
    rows = [[], []]
    for i in range(pieces + 1):
        angle = start + (end - start) * i / pieces
        rows[0].append(mesh.corner(outer, angle, y))
        rows[1].append(mesh.corner(inner, angle, y))
    mesh.strip(rows[0], rows[1], closed=False)


def dial():
    """Marks of a degree circle: long ones every 30 degrees, middle ones every 10, short ones every 2."""
    mesh = Mesh()
    for i in range(180):
        width, inner = (0.011, 6.12) if i % 15 == 0 else (0.007, 6.24) if i % 5 == 0 else (0.0038, 6.34)
        angle = TAU * i / 180
        arc(mesh, inner, 6.5, angle - width / 2, angle + width / 2, 0.0, 1)
    for inner, outer in ((6.0, 6.03), (6.55, 6.62)):
        arc(mesh, inner, outer, 0.0, TAU, 0.0, 160)
    mesh.write("dial.obj", "Degree marks of the table")


def skylight():
    """Twelve panes in a ring of radius 1, facing down."""
    mesh = Mesh()
    for i in range(12):
        arc(mesh, 1.0, 0.62, TAU * (i + 0.08) / 12, TAU * (i + 0.92) / 12, 0.0, 8)
    mesh.write("skylight.obj", "Twelve panes in a ring")


def stars():
    """Hexagons on a sphere of radius 60, facing its centre; sizes as of a real sky: few large ones."""
    mesh = Mesh()
    dice = random.Random(2008)
    placed = []
    while len(placed) < 260:
        y, angle = dice.uniform(-0.75, 0.8), dice.uniform(0, TAU)
        flat = math.sqrt(1 - y * y)
        to = (flat * math.cos(angle), y, flat * math.sin(angle))
        if any(sum(a * b for a, b in zip(to, other)) > 0.9965 for other in placed):
            continue
        placed.append(to)
        size = 0.09 + 0.17 * dice.random() ** 4
        side = (-math.sin(angle), 0.0, math.cos(angle))
        up = (to[1] * side[2] - to[2] * side[1], to[2] * side[0] - to[0] * side[2], to[0] * side[1] - to[1] * side[0])
        hexagon = []
        for corner in range(6):
            c, s = size * math.cos(TAU * corner / 6), size * math.sin(TAU * corner / 6)
            hexagon.append(mesh.point(*(60 * t + c * a + s * b for t, a, b in zip(to, side, up))))
        mesh.faces.append(tuple(hexagon))
    mesh.write("stars.obj", "A sky")


def gem():
    """An icosahedron of radius 1 whose faces are cut in four: 80 facets."""
    mesh = Mesh()
    g = (1 + math.sqrt(5)) / 2
    points = [(s * a, t * b, 0.0) for a, b in ((1, g),) for s in (-1, 1) for t in (-1, 1)]
    points += [(0.0, y, z) for y, _, z in ((p[0], 0, p[1]) for p in points[:4])]
    points += [(z, 0.0, x) for x, z, _ in points[:4]]

    def unit(p):
        length = math.sqrt(sum(c * c for c in p))
        return tuple(c / length for c in p)

    def near(a, b):
        return sum((p - q) ** 2 for p, q in zip(a, b)) < 4.1

    known = {}

    def corner(p):
        key = tuple(round(c, 6) for c in p)
        if key not in known:
            known[key] = mesh.point(*p)
        return known[key]

    def facet(a, b, c):
        normal = [(b[i - 2] - a[i - 2]) * (c[i - 1] - a[i - 1]) - (b[i - 1] - a[i - 1]) * (c[i - 2] - a[i - 2]) for i in range(3)]
        if sum(n * p for n, p in zip(normal, a)) < 0:
            b, c = c, b
        mesh.faces.append((corner(a), corner(b), corner(c)))

    count = len(points)
    for i in range(count):
        for j in range(i + 1, count):
            for k in range(j + 1, count):
                a, b, c = points[i], points[j], points[k]
                if not (near(a, b) and near(b, c) and near(a, c)):
                    continue
                ab, bc, ca = (unit([p + q for p, q in zip(u, v)]) for u, v in ((a, b), (b, c), (c, a)))
                a, b, c = unit(a), unit(b), unit(c)
                for piece in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)):
                    facet(*piece)
    mesh.write("sun.obj", "A cut gem of 80 facets, radius 1")


for teeth, spokes in ((24, 3), (32, 4), (48, 5), (60, 6), (64, 6), (72, 6), (80, 8), (96, 8)):
    gear(teeth, spokes)
turned("rod.obj", "Rod of radius 1 from y = 0 to 1", [(0, 0), (1, 0), (1, 1), (0, 1)], 48)
turned("collar.obj", "Collar", [(0, -0.05), (0.2, -0.05), (0.22, -0.03), (0.22, 0.03), (0.2, 0.05), (0, 0.05)], 40)
turned("foot.obj", "Foot of a spindle", [(0, 0.004), (0.17, 0.004), (0.17, 0.03), (0.13, 0.045), (0.075, 0.07), (0.06, 0.12), (0, 0.12)], 32)
turned("cup.obj", "Cup that holds a ball", [(0, -0.16), (0.035, -0.16), (0.035, -0.1), (0.05, -0.08), (0.09, -0.02), (0.12, 0.04), (0.1, 0.04), (0.06, 0.0), (0, -0.01)], 32)
turned("column.obj", "Foot of the column", [(0, 0.004), (0.62, 0.004), (0.62, 0.05), (0.55, 0.075), (0.5, 0.08), (0.34, 0.12), (0.24, 0.17), (0.2, 0.22), (0, 0.22)], 64)
turned("table.obj", "Round table top, its face at y = 0", [(0, -0.5), (5.9, -0.5), (6.3, -0.42), (6.62, -0.3), (6.78, -0.2), (6.84, -0.12), (6.84, -0.03), (6.81, 0), (0, 0)], 160)
band("ring_band.obj", "Ring of an armillary sphere, outer radius 1", 0.955, 1.0, 0.022, 128)
band("saturn_inner.obj", "Inner ring of a planet", 0.74, 0.96, 0.008, 128)
band("saturn_outer.obj", "Outer ring of a planet", 1.0, 1.2, 0.008, 128)
torus("hoop.obj", "Thin hoop of radius 1", 0.012, 128, 10)
torus("rim.obj", "Rim of the table, radius 1", 0.006, 192, 10)
gem()
dial()
skylight()
stars()

#!/usr/bin/env python3
"""Writes the meshes of the lagoon: a jellyfish in two poses, and a fish.

Run it in this folder. Public domain (CC0).
"""

from math import cos, pi, sin, sqrt


class Mesh:
    """Vertices and triangles."""

    def __init__(self):
        self.vertices, self.faces = [], []

    def tube(self, around, along, place, tip=None):
        """Rings of vertices in order of `along`, closed about; `tip` closes the end."""
        first = len(self.vertices)
        self.vertices += [place(i / around, j / along) for j in range(along + 1) for i in range(around)]
        for j in range(along):
            for i in range(around):
                a, b = first + j * around + i, first + j * around + (i + 1) % around
                c, d = b + around, a + around
                self.faces += [(a, b, c), (a, c, d)]
        if tip is not None:
            last = first + along * around
            self.vertices.append(tip)
            end = len(self.vertices) - 1
            self.faces += [(last + i, last + (i + 1) % around, end) for i in range(around)]

    def sheet(self, across, along, place):
        first = len(self.vertices)
        self.vertices += [place(i / across, j / along) for j in range(along + 1) for i in range(across + 1)]
        for j in range(along):
            for i in range(across):
                a = first + j * (across + 1) + i
                b, c, d = a + 1, a + across + 2, a + across + 1
                self.faces += [(a, b, c), (a, c, d)]

    def write(self, name):
        with open(name, "w", encoding="ascii") as file:
            file.write("# made by make_lagoon_set.py, CC0\n")
            for vertex in self.vertices:
                file.write("v " + " ".join(f"{x:.4g}" for x in vertex) + "\n")
            for face in self.faces:
                file.write("f " + " ".join(str(i + 1) for i in face) + "\n")


RIBS = 12
ARMS = 4
TENTACLES = 14


def jellyfish(squeeze):
    """About the y axis: a bell from y = 1 down to 0, 2 wide, arms and tentacles to y = -3. `squeeze` from 0, at rest, to 1."""
    mesh = Mesh()

    def rim(angle):
        """Radius and height of the bell's edge: its lappets, drawn in and down as it beats."""
        lappet = 0.5 + 0.5 * cos(RIBS * angle)
        return 1.05 - 0.34 * squeeze - 0.05 * lappet, -0.02 - 0.3 * squeeze - 0.10 * lappet

    def bell(angle, s, thick):
        """s from 0 at the crown to 1 at the edge."""
        radius, low = rim(angle)
        ridge = 1 + 0.035 * s * cos(RIBS * angle)
        high = 0.95 + 0.22 * squeeze - thick
        around = sin(s * pi / 2) ** 0.85 * (1 + 0.12 * sin(pi * s)) * (radius - thick * (1 - s)) * ridge
        return (cos(angle) * around, low + (high - low) * cos(s * pi / 2) ** 0.9, sin(angle) * around)

    outside, inside = 18, 12
    crown = 0.02
    mesh.tube(64, outside, lambda u, v: bell(-2 * pi * u, 1 - v * (1 - crown), 0.0), bell(0, 0, 0.0))
    mesh.tube(64, inside, lambda u, v: bell(2 * pi * u, 1 - v * (1 - crown), 0.16), bell(0, 0, 0.16))

    for arm in range(ARMS):
        turn = 2 * pi * arm / ARMS

        def frill(u, v, turn=turn):
            """A ruffled band that narrows as it hangs down."""
            wide = 0.34 * (1 - 0.75 * v) * (u - 0.5)
            ruffle = (0.05 + 0.1 * v) * sin(22 * v + 2.5 * turn) * (0.3 + abs(2 * u - 1))
            out = 0.16 + 0.1 * v + ruffle
            x, z = out, wide
            angle = turn + 1.1 * v
            y = 0.55 + 0.1 * squeeze - 2.3 * v
            return (cos(angle) * x - sin(angle) * z, y, sin(angle) * x + cos(angle) * z)

        mesh.sheet(6, 60, frill)

    for tentacle in range(TENTACLES):
        turn = 2 * pi * (tentacle + 0.5) / TENTACLES
        radius, low = rim(turn)
        length = 2.1 + 0.8 * sin(7.3 * tentacle) ** 2

        def thread(u, v, turn=turn, radius=radius, low=low, length=length):
            thick = 0.026 * (1 - 0.75 * v)
            out = (radius - 0.04) * (1 - 0.25 * v + 0.2 * squeeze * v)
            bend = 0.06 * sin(3 * turn + 5 * v)
            angle = 2 * pi * u
            x, z = out + thick * cos(angle), bend + thick * sin(angle)
            return (cos(turn) * x - sin(turn) * z, low + 0.04 - length * v, sin(turn) * x + cos(turn) * z)

        mesh.tube(5, 24, thread)
    return mesh


def fish():
    """1 in length, its head towards +x, up y; closed."""
    mesh = Mesh()

    def body(u, v):
        """From the nose back; bent a little, as it swims in a ring."""
        x = 0.5 - 0.86 * v
        swell = sqrt(max(v, 0.0)) * (1 - v) ** 0.8 * 1.9 + 0.05 * v
        angle = 2 * pi * u
        return (x, 0.2 * swell * sin(angle), 0.095 * swell * cos(angle) - 0.09 * x * x)

    mesh.tube(16, 12, body, (-0.37, 0, -0.09 * 0.37 ** 2))
    # A forked tail and two fins, thin.
    for tip, root in [((-0.62, 0.21), (-0.34, 0.0)), ((-0.62, -0.21), (-0.34, 0.0)), ((-0.12, 0.3), (0.12, 0.15)), ((-0.18, -0.24), (0.02, -0.14))]:
        first = len(mesh.vertices)
        back = (root[0] - 0.16, root[1] * 0.8)
        for (x, y), z in [(root, 0.012), (root, -0.012), (back, 0), (tip, 0)]:
            mesh.vertices.append((x, y, z - 0.09 * x * x))
        mesh.faces += [(first + a, first + b, first + c) for a, b, c in [(0, 2, 3), (1, 3, 2), (0, 3, 1), (0, 1, 2)]]
    return mesh


for name, mesh in [
    ("jellyfish", jellyfish(0.0)),
    ("jellyfish_beat", jellyfish(1.0)),
    ("fish", fish()),
]:
    mesh.write(f"lagoon/{name}.obj")
    print(name, len(mesh.vertices), len(mesh.faces))

#!/usr/bin/env python3
"""Writes the meshes that deform beside the wolf: a cloth and a square column, cut finely enough to bend.

Run it in this folder. Public domain (CC0).
"""


def write(name, vertices, faces):
    with open(name, "w", encoding="ascii") as file:
        file.write("# made by make_wolf_set.py, CC0\n")
        for vertex in vertices:
            file.write("v " + " ".join(f"{x:.6g}" for x in vertex) + "\n")
        for face in faces:
            file.write("f " + " ".join(str(i + 1) for i in face) + "\n")


def grid(across, down, place, first):
    """Triangles of a grid of vertices that begin at number `first`."""
    vertices = [place(i / across, j / down) for j in range(down + 1) for i in range(across + 1)]
    faces = []
    for j in range(down):
        for i in range(across):
            a = first + j * (across + 1) + i
            b, c, d = a + 1, a + across + 2, a + across + 1
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
    return vertices, faces


def cloth():
    """1 wide about x = 0, hanging 1 down from y = 0, in the plane z = 0."""
    return grid(48, 48, lambda u, v: (u - 0.5, v - 1, 0), 0)


def column():
    """1 high from y = 0, 0.2 thick, about the y axis; a lid, no foot."""
    corners = [(-0.1, 0.1), (0.1, 0.1), (0.1, -0.1), (-0.1, -0.1)]
    vertices, faces = [], []
    for side in range(4):
        (ax, az), (bx, bz) = corners[side], corners[(side + 1) % 4]
        place = lambda u, v: (ax + (bx - ax) * u, v, az + (bz - az) * u)
        more, triangles = grid(4, 64, place, len(vertices))
        vertices += more
        faces += triangles
    first = len(vertices)
    vertices += [(x, 1, z) for x, z in corners]
    faces += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return vertices, faces


write("cloth.obj", *cloth())
write("square_column.obj", *column())

"""Makes what scenes/looks.ron shows: small pictures and the meshes they are on. Run it in its folder."""

import math
import struct
import zlib


def png(name, size, texel):
    """Writes a picture; texel(x, y) gives red, green, blue and alpha from 0 to 1."""
    width, height = size
    rows = b"".join(
        b"\0" + bytes(round(255 * min(max(c, 0), 1)) for x in range(width) for c in texel(x, y))
        for y in range(height)
    )

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    with open(name, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def noise(x, y):
    return math.sin(x * 12.9898 + y * 78.233) * 43758.5453 % 1


def tile_height(x, y):
    """Two tiles a picture of 64 texels along each edge, with rounded edges; 0 in the joints."""
    edge = min(x % 32, 31 - x % 32, y % 32, 31 - y % 32) + 0.5
    return min(edge / 4, 1) ** 0.5


def tiles(x, y):
    dark = (x // 32 + y // 32) % 2
    if tile_height(x, y) < 0.6:
        return 0.16, 0.15, 0.14, 1
    grain = 0.9 + 0.1 * noise(x // 2, y // 2)
    color = (0.23, 0.3, 0.34) if dark else (0.86, 0.82, 0.72)
    return *(c * grain for c in color), 1


def tile_normals(x, y):
    left, right = tile_height((x - 1) % 64, y), tile_height((x + 1) % 64, y)
    above, below = tile_height(x, (y - 1) % 64), tile_height(x, (y + 1) % 64)
    nx, ny, nz = (left - right) * 0.8, (below - above) * 0.8, 1
    length = math.hypot(nx, ny, nz)
    return nx / length / 2 + 0.5, ny / length / 2 + 0.5, nz / length / 2 + 0.5, 1


def stripes(x, y):
    """A ball of six colours, a white band around it."""
    if 13 <= y < 19:
        return 0.95, 0.95, 0.92, 1
    hues = [(0.85, 0.2, 0.15), (0.95, 0.65, 0.1), (0.25, 0.6, 0.25), (0.1, 0.45, 0.75), (0.4, 0.25, 0.6), (0.9, 0.45, 0.5)]
    return *hues[x * 6 // 64], 1


def lattice(x, y):
    """Leaves on a trellis: what is not leaf or wood is a hole."""
    u, v = x % 32 - 15.5, y % 32 - 15.5
    wood = abs((x + y) % 32 - 16) < 3 or abs((x - y) % 32 - 16) < 3
    leaf = (u / 13) ** 2 + (v / 7) ** 2 < 1 if (x // 32 + y // 32) % 2 else (u / 7) ** 2 + (v / 13) ** 2 < 1
    if leaf:
        vein = abs(u) < 1 or abs(v) < 1
        return (0.45, 0.62, 0.22, 1) if vein else (0.2, 0.42 + 0.1 * noise(x, y), 0.12, 1)
    if wood:
        return 0.5, 0.36, 0.2, 1
    return 0.2, 0.4, 0.12, 0


def obj(name, vertices, uvs, faces):
    with open(name, "w") as file:
        for vertex in vertices:
            file.write("v %.5g %.5g %.5g\n" % vertex)
        for uv in uvs:
            file.write("vt %.5g %.5g\n" % uv)
        for face in faces:
            file.write("f " + " ".join("%d/%d" % corner for corner in face) + "\n")


def rectangle(name, corners, times):
    across, up = times
    uvs = [(0, 0), (across, 0), (across, up), (0, up)]
    obj(name, corners, uvs, [[(i + 1, i + 1) for i in range(4)]])


def globe(name, columns, rows):
    vertices, uvs, faces = [], [], []
    for row in range(rows + 1):
        for column in range(columns + 1):
            around, down = 2 * math.pi * column / columns, math.pi * row / rows
            uvs.append((column / columns, 1 - row / rows))
            place = math.sin(down) * math.sin(around), math.cos(down), math.sin(down) * math.cos(around)
            vertices.append(place)
    for row in range(rows):
        for column in range(columns):
            a = row * (columns + 1) + column + 1
            b = a + columns + 1
            corners = [a, b, b + 1, a + 1]
            if row == 0:
                corners = [a, b, b + 1]
            elif row == rows - 1:
                corners = [a, b, a + 1]
            faces.append([(i, i) for i in corners])
    obj(name, vertices, uvs, faces)


png("tiles.png", (64, 64), tiles)
png("tile_normals.png", (64, 64), tile_normals)
png("stripes.png", (64, 32), stripes)
png("lattice.png", (64, 64), lattice)
rectangle("floor.obj", [(-8, 0, 8), (8, 0, 8), (8, 0, -8), (-8, 0, -8)], (16, 16))
rectangle("screen.obj", [(-1, 0, 0), (1, 0, 0), (1, 2, 0), (-1, 2, 0)], (2, 2))
globe("globe.obj", 24, 12)

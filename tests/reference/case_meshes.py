#!/usr/bin/env python3
"""Writes the meshes of cases: scenes/cases/notch.obj of blocks, gallbladder_duct.obj of tubes.

    python3 tests/reference/case_meshes.py     (from the repository's root)
"""

import math


def planes(*stretches):
    """Grid planes: stretches of (from, to, number of cells), m."""
    values = [stretches[0][0]]
    for begin, end, cells in stretches:
        values += [begin + (end - begin) * (i + 1) / cells for i in range(cells)]
    return values


def write_blocks(name, comment, axes, solid):
    """Writes the surface of the grid's cells for whose centres solid(x, y, z) holds."""
    counts = [len(axis) - 1 for axis in axes]
    centre = lambda cell: [(axis[i] + axis[i + 1]) / 2 for axis, i in zip(axes, cell)]
    filled = {(i, j, k) for i in range(counts[0]) for j in range(counts[1])
              for k in range(counts[2]) if solid(*centre((i, j, k)))}
    number, lines, faces = {}, [], []

    def vertex(corner):
        if corner not in number:
            number[corner] = len(number) + 1
            lines.append("v " + " ".join(f"{axis[i]:.6g}" for axis, i in zip(axes, corner)))
        return number[corner]

    for cell in sorted(filled):
        for d in range(3):
            for side in (0, 1):
                beside = list(cell)
                beside[d] += 2 * side - 1
                if tuple(beside) in filled:
                    continue
                a, b = (d + 1) % 3, (d + 2) % 3
                quad = []
                for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cell)
                    corner[d] += side
                    corner[a] += s
                    corner[b] += t
                    quad.append(vertex(tuple(corner)))
                if side == 0:
                    quad.reverse()
                # Diagonals alternate, so that no direction is preferred.
                turn = sum(cell) % 2
                q = quad[turn:] + quad[:turn]
                faces += [f"f {q[0]} {q[1]} {q[2]}", f"f {q[0]} {q[2]} {q[3]}"]
    with open(f"scenes/cases/{name}.obj", "w") as file:
        file.write(f"# {comment}\n# made by: tests/reference/case_meshes.py\n")
        file.write("\n".join(lines + faces) + "\n")


write_blocks("notch",
             "A block of 82 x 30 x 40 mm with a slit 2 mm wide and 26 mm deep, m.",
             (planes((-0.041, -0.001, 8), (-0.001, 0.001, 1), (0.001, 0.041, 8)),
              planes((-0.015, 0.015, 6)), planes((-0.02, -0.006, 3), (-0.006, 0.02, 6))),
             lambda x, y, z: abs(x) > 0.001 or z < -0.006)


def write_tubes(name, comment, tubes):
    """Writes closed tubes: (end point, rings of points, end point, True if the faces look inwards)."""
    lines, faces = [], []

    def vertex(p):
        lines.append("v " + " ".join(f"{x:.6g}" for x in p))
        return len(lines)

    for first, rings, last, inward in tubes:
        begin, end = vertex(first), vertex(last)
        numbers = [[vertex(p) for p in ring] for ring in rings]
        triangles = []
        for i in range(len(rings[0])):
            j = (i + 1) % len(rings[0])
            triangles.append((begin, numbers[0][j], numbers[0][i]))
            triangles.append((end, numbers[-1][i], numbers[-1][j]))
            for r, (low, high) in enumerate(zip(numbers, numbers[1:])):
                # Diagonals alternate, so that no direction is preferred.
                if (i + r) % 2:
                    triangles += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
                else:
                    triangles += [(low[i], low[j], high[i]), (low[j], high[j], high[i])]
        faces += [f"f {a} {c} {b}" if inward else f"f {a} {b} {c}" for a, b, c in triangles]
    with open(f"scenes/cases/{name}.obj", "w") as file:
        file.write(f"# {comment}\n# made by: tests/reference/case_meshes.py\n")
        file.write("\n".join(lines + faces) + "\n")


# A gallbladder: a pear along z from its fundus at z = 0, and a duct that turns towards x, m.
FUNDUS, BODY, DUCT, TURN = 0.017, 0.058, 0.032, math.radians(75)
BODY_RADIUS, DUCT_RADIUS, BODY_WALL, DUCT_WALL = 0.015, 0.0045, 0.003, 0.002


def smooth_step(s, begin, end):
    t = min(1.0, max(0.0, (s - begin) / (end - begin)))
    return t * t * (3 - 2 * t)


def cap(s, depth, radius):
    """Radius of an ellipsoid's cap of `depth` that ends at FUNDUS."""
    return radius * math.sqrt(max(0.0, 1 - ((FUNDUS - s) / depth) ** 2))


def outer_radius(s):
    if s < FUNDUS:
        return cap(s, FUNDUS, BODY_RADIUS)
    return BODY_RADIUS + smooth_step(s, FUNDUS, BODY) * (DUCT_RADIUS - BODY_RADIUS)


def lumen_radius(s):
    if s < FUNDUS:
        return cap(s, FUNDUS - BODY_WALL, BODY_RADIUS - BODY_WALL)
    return outer_radius(s) - BODY_WALL - smooth_step(s, 0.03, BODY) * (DUCT_WALL - BODY_WALL)


def centre_line(s):
    """The point at the length s, and two axes across."""
    bend = DUCT / TURN
    angle = max(0.0, s - BODY) / bend
    point = (bend * (1 - math.cos(angle)), 0, min(s, BODY) + bend * math.sin(angle))
    return point, (math.cos(angle), 0, -math.sin(angle)), (0, 1, 0)


def rings(lengths, radius_at, around=28):
    def ring(s):
        point, across, up = centre_line(s)
        angles = [2 * math.pi * i / around for i in range(around)]
        return [[p + radius_at(s) * (math.cos(t) * a + math.sin(t) * u)
                 for p, a, u in zip(point, across, up)] for t in angles]
    return [ring(s) for s in lengths]


def stations(begin, end_wall, along_duct):
    """Lengths of the rings from a fundus at `begin` to `end_wall` before the duct's end."""
    cap_depth = FUNDUS - begin
    end = BODY + DUCT - end_wall
    return ([begin + cap_depth * (1 - math.cos(math.pi / 2 * i / 6)) for i in range(1, 6)] +
            planes((FUNDUS, BODY, 14), (BODY, end, along_duct)))


write_tubes("gallbladder_duct",
            "A gallbladder of 58 mm with a duct of 32 mm; walls of 3 and 2 mm, m.",
            [((0, 0, 0), rings(stations(0, 0, 12), outer_radius), centre_line(BODY + DUCT)[0],
              False),
             ((0, 0, BODY_WALL), rings(stations(BODY_WALL, BODY_WALL, 11), lumen_radius),
              centre_line(BODY + DUCT - BODY_WALL)[0], True)])

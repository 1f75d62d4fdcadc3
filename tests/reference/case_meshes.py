#!/usr/bin/env python3
"""Writes the meshes of cases that are made of blocks: scenes/cases/notch.obj.

    python3 tests/reference/case_meshes.py     (from the repository's root)
"""


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

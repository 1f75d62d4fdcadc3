#!/usr/bin/env python3
"""Writes the references that closed forms give: bar and sphere_pressure, and the sphere's mesh.

    python3 tests/reference/closed_forms.py     (from the repository's root)
"""
import json
import math

CASES, HERE = "scenes/cases/", "tests/reference/"


def read_obj(path):
    return [tuple(map(float, line.split()[1:4])) for line in open(path) if line.startswith("v ")]


def write(name, vertices, displacement, facts):
    with open(f"{HERE}{name}.csv", "w") as file:
        file.write("x,y,z,ux,uy,uz\n")
        for p in vertices:
            file.write(",".join(f"{x:.6g}" for x in (*p, *displacement(p))) + "\n")
    with open(f"{HERE}{name}.json", "w") as file:
        file.write(json.dumps({"case": name, "surface_vertices": len(vertices), **facts}, indent=2))
        file.write("\n")


def bar(young=5000.0, pull=10.0):
    """Uniaxial tension without lateral contraction, held for x <= 0: u_x = pull x / E."""
    write("bar", read_obj(CASES + "beam.obj"), lambda p: (pull / young * max(p[0], 0), 0, 0),
          {"closed_form": "u_x = pull x / E for x > 0", "young_Pa": young, "poisson": 0.0,
           "pressure_Pa": -pull})


def icosphere(splits):
    g = (1 + math.sqrt(5)) / 2
    vertices = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g),
                (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
                 (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8),
                 (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    unit = lambda p: tuple(x / math.hypot(*p) for x in p)
    vertices = [unit(p) for p in vertices]
    for _ in range(splits):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(vertices)
                vertices.append(unit(tuple(x + y for x, y in zip(vertices[a], vertices[b]))))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    order = list(dict.fromkeys(v for t in triangles for v in t))  # as an importer meets them
    place = {v: i for i, v in enumerate(order)}
    return [vertices[v] for v in order], [tuple(place[v] for v in t) for t in triangles]


def sphere_pressure(inner=0.025, outer=0.05, young=5000.0, poisson=0.3, pressure=100.0):
    """A thick-walled sphere under a pressure in its cavity (Lame): with a, b the radii,
    u_r = p a^3 / (E (b^3 - a^3)) ((1 - 2 nu) r + (1 + nu) b^3 / (2 r^2))."""
    unit, triangles = icosphere(3)
    volume = sum(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                 a[2] * (b[0] * c[1] - b[1] * c[0])
                 for a, b, c in ([unit[v] for v in t] for t in triangles)) / 6
    grown = (4 * math.pi / 3 / volume) ** (1 / 3)  # the polyhedra have the spheres' volumes
    with open(CASES + "sphere.obj", "w") as file:
        file.write("# A sphere of 50 mm radius with a cavity of 25 mm radius, m.\n"
                   "# made by: tests/reference/closed_forms.py\n")
        for radius, side in ((outer, 1), (inner, -1)):  # mirrored: the same order turns inwards
            for x, y, z in unit:
                p = (side * x, y, z)
                file.write("v " + " ".join(f"{radius * grown * x:.6g}" for x in p) + "\n")
        for first in (1, 1 + len(unit)):
            for t in triangles:
                file.write("f " + " ".join(str(first + v) for v in t) + "\n")

    def displacement(p):
        r = math.hypot(*p)
        u = (pressure * inner**3 / (young * (outer**3 - inner**3)) *
             ((1 - 2 * poisson) * r + (1 + poisson) * outer**3 / (2 * r**2)))
        return tuple(u * x / r for x in p)

    write("sphere_pressure", read_obj(CASES + "sphere.obj"), displacement,
          {"closed_form": "u_r = p a^3 / (E (b^3 - a^3)) ((1 - 2 nu) r + (1 + nu) b^3 / (2 r^2))",
           "young_Pa": young, "poisson": poisson, "pressure_Pa": pressure})


bar()
sphere_pressure()

"""Reads what `hpdm log export --format vtk` wrote, with Python's standard library alone.

    read_vtk.py INDEX.pvd

Prints each entry of the index, "TIME FILE", then an empty line, then for each vertex of the last
entry's surface its position and displacement (six numbers), then an empty line, then its triangles.
"""

import array
import base64
import pathlib
import struct
import sys
import xml.etree.ElementTree as ElementTree

TYPES = {"Float32": "f", "Int32": "i"}


def numbers(element):
    data = base64.b64decode(element.text)
    (size,) = struct.unpack_from("<Q", data)
    values = array.array(TYPES[element.get("type")])
    values.frombytes(data[8:])
    assert len(data) == 8 + size
    return values


def rows(values):
    return [tuple(values[i : i + 3]) for i in range(0, len(values), 3)]


def main():
    index = pathlib.Path(sys.argv[1])
    entries = ElementTree.parse(index).findall("Collection/DataSet")
    for entry in entries:
        print(entry.get("timestep"), entry.get("file"))
    file = ElementTree.parse(index.parent / entries[-1].get("file"))
    assert file.getroot().get("header_type") == "UInt64"
    piece = file.find("PolyData/Piece")
    points = rows(numbers(piece.find("Points/DataArray")))
    moved = rows(numbers(piece.find("PointData/DataArray[@Name='displacement']")))
    corners = rows(numbers(piece.find("Polys/DataArray[@Name='connectivity']")))
    ends = numbers(piece.find("Polys/DataArray[@Name='offsets']"))
    assert len(points) == len(moved) == int(piece.get("NumberOfPoints"))
    assert len(corners) == int(piece.get("NumberOfPolys"))
    assert list(ends) == list(range(3, 3 * len(corners) + 3, 3))
    print()
    for point, displacement in zip(points, moved):
        print(*(f"{x:.9g}" for x in point + displacement))
    print()
    for triangle in corners:
        print(*triangle)


if __name__ == "__main__":
    main()

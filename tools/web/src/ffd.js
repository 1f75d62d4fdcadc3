// Computes the surface of an organ from its rest mesh and its HPDM_ORGAN (lcmtypes/README.md):
//
//     x = X + sum_a phi_a(X) U_a + local functions + dents + offset                         (Eq. 4)
//
// The basis functions' values at each vertex never change and are computed once, one factor per
// axis. Units m, world axes; arrays have x, y, z of one vertex after another.

/// Decodes a base64 text into numbers of `Type` (a typed array).
export function numbers(text, Type) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Type(bytes.buffer);
}

/// Values at c (0..1) of the functions first .. first + degree along one axis, into `values` from
/// `at` on; returns first. As engine/lattice/basis.cc.
export function evaluate(bernstein, degree, cells, c, values, at) {
  c = Math.min(Math.max(c, 0), 1);
  if (bernstein) {
    let binomial = 1, power = 1;
    for (let i = 0; i <= degree; ++i) {
      values[at + i] = binomial * power;
      binomial *= (degree - i) / (i + 1);
      power *= c;
    }
    power = 1;
    for (let i = degree; i >= 0; --i) {
      values[at + i] *= power;
      power *= 1 - c;
    }
    return 0;
  }
  const scaled = c * cells;
  const cell = Math.min(Math.trunc(scaled), cells - 1);
  const t = scaled - cell, s = 1 - t;
  if (degree === 1) {
    values[at] = s;
    values[at + 1] = t;
  } else if (degree === 2) {
    values[at] = s * s / 2;
    values[at + 1] = 0.5 + t * s;
    values[at + 2] = t * t / 2;
  } else {
    values[at] = s * s * s / 6;
    values[at + 1] = (4 + t * t * (3 * t - 6)) / 6;
    values[at + 2] = (4 + s * s * (3 * s - 6)) / 6;
    values[at + 3] = t * t * t / 6;
  }
  return cell;
}

/// A tensor basis over a lattice's box, evaluated at points.
class Basis {
  constructor(lattice, refinement, points) {
    const bernstein = lattice.basis === 'bernstein';
    this.degree = lattice.degree;
    const cells = lattice.cells.map((n) => bernstein ? 1 : n * refinement);
    this.counts = cells.map((n, d) => n + this.degree[d]);
    const vertices = points.length / 3;
    this.first = [0, 1, 2].map(() => new Int32Array(vertices));
    this.values = this.degree.map((p) => new Float64Array(vertices * (p + 1)));
    for (let v = 0; v < vertices; ++v) {
      for (let d = 0; d < 3; ++d) {
        let c = 0;
        for (let k = 0; k < 3; ++k) c += lattice.axes[d][k] * (points[3 * v + k] - lattice.origin[k]);
        this.first[d][v] = evaluate(bernstein, this.degree[d], cells[d], c / lattice.lengths[d],
                                    this.values[d], v * (this.degree[d] + 1));
      }
    }
  }

  /// Adds to `x` each point's displacement under those of a full grid (3 each).
  addGrid(grid, x) {
    const [p, q, r] = this.degree, [, ny, nz] = this.counts;
    const [fx, fy, fz] = this.first, [vx, vy, vz] = this.values;
    for (let v = 0; v < fx.length; ++v) {
      let ux = 0, uy = 0, uz = 0;
      for (let i = 0; i <= p; ++i) {
        const a = vx[v * (p + 1) + i];
        for (let j = 0; j <= q; ++j) {
          const ab = a * vy[v * (q + 1) + j];
          let at = 3 * (((fx[v] + i) * ny + fy[v] + j) * nz + fz[v]);
          for (let k = 0; k <= r; ++k, at += 3) {
            const w = ab * vz[v * (r + 1) + k];
            ux += w * grid[at];
            uy += w * grid[at + 1];
            uz += w * grid[at + 2];
          }
        }
      }
      x[3 * v] += ux;
      x[3 * v + 1] += uy;
      x[3 * v + 2] += uz;
    }
  }

  /// Adds to `x` each point's displacement under a few functions, given by grid index.
  addFunctions(indices, displacements, x) {
    const [p, q, r] = this.degree, [nx, ny, nz] = this.counts;
    const [fx, fy, fz] = this.first, [vx, vy, vz] = this.values;
    for (let a = 0; a < indices.length; ++a) {
      if (indices[a] < 0 || indices[a] >= nx * ny * nz) continue;
      const k = indices[a] % nz, j = Math.trunc(indices[a] / nz) % ny;
      const i = Math.trunc(indices[a] / (ny * nz));
      for (let v = 0; v < fx.length; ++v) {
        const di = i - fx[v], dj = j - fy[v], dk = k - fz[v];
        if (di < 0 || di > p || dj < 0 || dj > q || dk < 0 || dk > r) continue;
        const w = vx[v * (p + 1) + di] * vy[v * (q + 1) + dj] * vz[v * (r + 1) + dk];
        for (let d = 0; d < 3; ++d) x[3 * v + d] += w * displacements[3 * a + d];
      }
    }
  }
}

/// Computes unit normals of the vertices: the area-weighted mean over the triangles around each.
export function vertexNormals(x, triangles, normals) {
  normals.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
    const px = x[b] - x[a], py = x[b + 1] - x[a + 1], pz = x[b + 2] - x[a + 2];
    const qx = x[c] - x[a], qy = x[c + 1] - x[a + 1], qz = x[c + 2] - x[a + 2];
    const nx = py * qz - pz * qy, ny = pz * qx - px * qz, nz = px * qy - py * qx;
    for (const i of [a, b, c]) {
      normals[i] += nx;
      normals[i + 1] += ny;
      normals[i + 2] += nz;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]);
    if (!(length > 0)) continue;
    normals[i] /= length;
    normals[i + 1] /= length;
    normals[i + 2] /= length;
  }
}

/// Returns how deep a half-space's surface sinks at s radii from a load's centre
/// (engine/contact/half_space.h). Uses the server's table of even steps up to `end`, then two terms
/// of a series.
export function makeSinking({end, values, tail}) {
  const table = numbers(values, Float64Array), intervals = table.length - 1;
  return (s) => {
    if (s >= end) return (1 + tail / (s * s)) / (Math.PI * s);
    const at = s * intervals / end;
    const i = Math.min(Math.trunc(at), intervals - 1);
    return table[i] + (at - i) * (table[i + 1] - table[i]);
  };
}

/// An organ's surface: `positions` and `normals` (Float32Array) after the last deform().
export class OrganSurface {
  /// `mesh`: the reply of /mesh/N.
  constructor(mesh) {
    this.name = mesh.name;
    this.rest = numbers(mesh.vertices, Float32Array);
    this.triangles = numbers(mesh.triangles, Int32Array);
    this.positions = this.rest.slice();
    this.normals = new Float32Array(this.rest.length);
    this.restNormals = new Float32Array(this.rest.length);
    vertexNormals(this.rest, this.triangles, this.restNormals);
    this.normals.set(this.restNormals);
    this.x = Float64Array.from(this.rest);
    const lattice = mesh.lattice;
    if (!lattice) return;
    this.kept = numbers(lattice.kept, Int32Array);
    this.basis = new Basis(lattice, 1, this.rest);
    const [nx, ny, nz] = this.basis.counts;
    this.grid = new Float64Array(3 * nx * ny * nz);
    if (lattice.local_refinement > 0) {
      this.finer = new Basis(lattice, lattice.local_refinement, this.rest);
    }
  }

  /// Moves the vertices by a member of an update's `organs`.
  deform(shape, sinking) {
    const x = this.x;
    x.set(this.rest);
    if (shape.displacements !== undefined && shape.fits) this.displace(shape, sinking);
    this.positions.set(x);
    vertexNormals(x, this.triangles, this.normals);
  }

  displace(shape, sinking) {
    const x = this.x, u = numbers(shape.displacements, Float32Array);
    if (this.basis) {
      this.kept.forEach((index, a) => this.grid.set(u.subarray(3 * a, 3 * a + 3), 3 * index));
      this.basis.addGrid(this.grid, x);
      if (this.finer) {
        this.finer.addFunctions(numbers(shape.local_functions, Int32Array),
                                numbers(shape.local_displacements, Float32Array), x);
      }
    } else if (u.length === x.length) {
      for (let i = 0; i < x.length; ++i) x[i] += u[i];
    }
    for (const dent of shape.dents) this.addDent(dent, sinking, x);
    for (let i = 0; i < x.length; ++i) x[i] += shape.offset[i % 3];
  }

  addDent({centre, normal, radius, resolved_radius: resolved, strength}, sinking, x) {
    if (!(radius < resolved)) return;
    const rest = this.rest, n = this.restNormals;
    for (let v = 0; v < rest.length; v += 3) {
      const d = Math.hypot(rest[v] - centre[0], rest[v + 1] - centre[1], rest[v + 2] - centre[2]);
      if (d >= 4 * resolved) continue;
      if (n[v] * normal[0] + n[v + 1] * normal[1] + n[v + 2] * normal[2] <= 0) continue;
      const shape = sinking(d / radius) / radius - sinking(d / resolved) / resolved;
      for (let k = 0; k < 3; ++k) x[v + k] += shape * strength[k];
    }
  }
}

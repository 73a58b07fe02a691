/* shapes: the meshes that bodies are drawn by, one a kind of shape or geometry. A vertex has a core and a direction:
 * the vertex shader puts it at core x half extents + direction x radius, so that one mesh serves every size and every
 * rounding of its kind. For drawing only: what is claimed and checked uses the shapes themselves. */
import { BufferAttribute, BufferGeometry, Vector3 } from "three";
import { ConvexHull } from "three/addons/math/ConvexHull.js";
import { Shape, type GeometryFrame } from "../../client/src/index.js";

/** How normals are found: as the direction says; as an ellipsoid's; from the triangle itself; and a ground's grid. */
export const Shading = { direction: 0, ellipsoid: 1, flat: 2, ground: 3 } as const;

export interface Mesh { geometry: BufferGeometry; shading: number }

function build(core: number[], direction: number[], index: number[]): BufferGeometry {
  const g = new BufferGeometry();
  g.setAttribute("position", new BufferAttribute(new Float32Array(core), 3));
  g.setAttribute("normal", new BufferAttribute(new Float32Array(direction), 3));
  g.setIndex(index);
  return g;
}

/** Turns a profile around z: each point has a core (distance from the axis, height) and a direction (likewise). */
function revolve(profile: [number, number, number, number][], sides: number): BufferGeometry {
  const core: number[] = [], direction: number[] = [], index: number[] = [];
  for (let s = 0; s <= sides; s++) {
    const c = Math.cos((2 * Math.PI * s) / sides), n = Math.sin((2 * Math.PI * s) / sides);
    for (const [r, z, dr, dz] of profile) {
      core.push(r * c, r * n, z);
      direction.push(dr * c, dr * n, dz);
    }
  }
  const rows = profile.length;
  for (let s = 0; s < sides; s++)
    for (let i = 0; i + 1 < rows; i++) {
      const a = s * rows + i, b = a + rows;
      index.push(a, b, b + 1, a, b + 1, a + 1);
    }
  return build(core, direction, index);
}

/** Points of a profile that stay at one core while the direction turns from one elevation to another (degrees). */
function arc(r: number, z: number, from: number, to: number, steps: number): [number, number, number, number][] {
  const out: [number, number, number, number][] = [];
  for (let i = 0; i <= steps; i++) {
    const e = ((from + ((to - from) * i) / steps) * Math.PI) / 180;
    out.push([r, z, Math.cos(e), Math.sin(e)]);
  }
  return out;
}

function box(rounded: boolean): BufferGeometry {
  const core: number[] = [], direction: number[] = [], index: number[] = [];
  const steps = rounded ? 3 : 0;
  for (let axis = 0; axis < 3; axis++)
    for (const side of [-1, 1]) {
      const first = core.length / 3, u = (axis + 1) % 3, v = (axis + 2) % 3, row = 2 * (steps + 1);
      // A face of a rounded box: each corner has (steps + 1)^2 vertices whose directions turn to the neighbours.
      for (let j = 0; j < row; j++)
        for (let i = 0; i < row; i++) {
          const su = i <= steps ? -1 : 1, sv = j <= steps ? -1 : 1;
          const tu = steps === 0 ? 0 : (i <= steps ? steps - i : i - steps - 1) / steps;
          const tv = steps === 0 ? 0 : (j <= steps ? steps - j : j - steps - 1) / steps;
          const d = [0, 0, 0], c = [0, 0, 0];
          d[axis] = side; d[u] = su * Math.tan((tu * Math.PI) / 4); d[v] = sv * Math.tan((tv * Math.PI) / 4);
          c[axis] = side; c[u] = su; c[v] = sv;
          const length = Math.hypot(d[0]!, d[1]!, d[2]!);
          core.push(...c);
          direction.push(d[0]! / length, d[1]! / length, d[2]! / length);
        }
      for (let j = 0; j + 1 < row; j++)
        for (let i = 0; i + 1 < row; i++) {
          const a = first + j * row + i, q = [a, a + 1, a + row + 1, a, a + row + 1, a + row];
          index.push(...(side > 0 ? q : q.reverse()));
        }
    }
  return build(core, direction, index);
}

function ground(): BufferGeometry {
  return build([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1], [0, 1, 2, 0, 2, 3]);
}

function ofKind(type: number, rounded: boolean): Mesh | null {
  switch (type) {
    case Shape.sphere: case Shape.capsule:
      return { geometry: revolve([...arc(0, -1, -90, 0, 5), ...arc(0, 1, 0, 90, 5)], 20), shading: Shading.direction };
    case Shape.box: return { geometry: box(rounded), shading: Shading.direction };
    case Shape.cylinder:
      return {
        geometry: revolve([[0, -1, 0, -1], ...arc(1, -1, -90, 0, rounded ? 4 : 1), ...arc(1, 1, 0, 90, rounded ? 4 : 1),
          [0, 1, 0, 1]], 24), shading: Shading.direction,
      };
    case Shape.cone:
      return {
        geometry: revolve([[0, -1, 0, -1], ...arc(1, -1, -90, 30, rounded ? 4 : 1), ...arc(0, 1, 30, 90, rounded ? 4 : 1)],
          24), shading: Shading.flat,
      };
    case Shape.ellipsoid: {
      const p: [number, number, number, number][] = arc(0, 0, -90, 90, 12).map(([, , r, z]) => [r, z, r, z]);
      return { geometry: revolve(p, 24), shading: Shading.ellipsoid };
    }
    case Shape.halfspace: return { geometry: ground(), shading: Shading.ground };
    default: return null;
  }
}

/** Smooth directions for rounding: the mean of the normals of the triangles around each vertex. */
function directions(core: Float32Array, index: ArrayLike<number>): Float32Array {
  const out = new Float32Array(core.length), a = new Vector3(), b = new Vector3(), c = new Vector3();
  for (let t = 0; t + 2 < index.length; t += 3) {
    a.fromArray(core, 3 * index[t]!);
    b.fromArray(core, 3 * index[t + 1]!).sub(a);
    c.fromArray(core, 3 * index[t + 2]!).sub(a);
    b.cross(c);
    for (let k = 0; k < 3; k++) {
      const at = 3 * index[t + k]!;
      out[at] = out[at]! + b.x; out[at + 1] = out[at + 1]! + b.y; out[at + 2] = out[at + 2]! + b.z;
    }
  }
  for (let i = 0; i < out.length; i += 3) {
    const l = Math.hypot(out[i]!, out[i + 1]!, out[i + 2]!) || 1;
    out[i] = out[i]! / l; out[i + 1] = out[i + 1]! / l; out[i + 2] = out[i + 2]! / l;
  }
  return out;
}

function hullFaces(numbers: Float64Array): number[] {
  const points: Vector3[] = [], at = new Map<Vector3, number>();
  for (let i = 0; i + 2 < numbers.length; i += 3) {
    const p = new Vector3(numbers[i], numbers[i + 1], numbers[i + 2]);
    at.set(p, i / 3);
    points.push(p);
  }
  const index: number[] = [];
  if (points.length < 4) return index;
  for (const face of new ConvexHull().setFromPoints(points).faces) {
    const corners: number[] = [];
    let edge = face.edge;
    do {
      corners.push(at.get(edge.head().point)!);
      edge = edge.next;
    } while (edge !== face.edge);
    for (let i = 1; i + 1 < corners.length; i++) index.push(corners[0]!, corners[i]!, corners[i + 1]!);
  }
  return index;
}

function heightField(f: GeometryFrame): { core: Float32Array; index: number[] } {
  const [dx = 1, dy = 1, base = 0] = f.numbers, columns = f.indices[0] ?? 0, rows = f.indices[1] ?? 0;
  const height = (r: number, c: number): number => f.numbers[3 + r * columns + c] ?? 0, core: number[] = [];
  let lowest = Infinity;
  for (let i = 3; i < f.numbers.length; i++) lowest = Math.min(lowest, f.numbers[i]!);
  for (let r = 0; r < rows; r++)
    for (let c = 0; c < columns; c++)
      core.push((c - (columns - 1) / 2) * dx, (r - (rows - 1) / 2) * dy, height(r, c));
  const index: number[] = [];
  for (let r = 0; r + 1 < rows; r++)
    for (let c = 0; c + 1 < columns; c++) {
      const a = r * columns + c, b = a + columns;
      index.push(a, a + 1, b + 1, a, b + 1, b);
    }
  // The rim goes down to the flat base.
  const rim: number[] = [];
  for (let c = 0; c < columns; c++) rim.push(c);
  for (let r = 1; r < rows; r++) rim.push(r * columns + columns - 1);
  for (let c = columns - 2; c >= 0; c--) rim.push((rows - 1) * columns + c);
  for (let r = rows - 2; r > 0; r--) rim.push(r * columns);
  const first = core.length / 3;
  for (const v of rim) core.push(core[3 * v]!, core[3 * v + 1]!, lowest - base);
  for (let i = 0; i < rim.length; i++) {
    const j = (i + 1) % rim.length;
    index.push(rim[i]!, first + i, first + j, rim[i]!, first + j, rim[j]!);
  }
  return { core: new Float32Array(core), index };
}

/** The mesh of a geometry that was sent; its core is in metres, so that its half extents are 1. */
function ofGeometry(f: GeometryFrame): Mesh {
  let core: Float32Array, index: ArrayLike<number>;
  if (f.of === 3) ({ core, index } = heightField(f));
  else {
    core = new Float32Array(f.numbers);
    index = f.of === 2 ? f.indices : f.faces.length > 0 ? f.faces : hullFaces(f.numbers);
  }
  const g = new BufferGeometry();
  g.setAttribute("position", new BufferAttribute(core, 3));
  g.setAttribute("normal", new BufferAttribute(directions(core, index), 3));
  g.setIndex(new BufferAttribute(new Uint32Array(index), 1));
  return { geometry: g, shading: Shading.flat };
}

/** The name of the mesh that a shape is drawn by; those with one name are one draw. */
export function meshKey(type: number, radius: number, geometry: number): string {
  if (type === Shape.capsule) return String(Shape.sphere);
  if (type === Shape.box || type === Shape.cylinder || type === Shape.cone) return `${type}${radius > 0 ? "r" : ""}`;
  return type >= Shape.hull ? `g${geometry}` : String(type);
}

/** The mesh of that name; null if its geometry has not come. */
export function meshOf(type: number, radius: number, geometry: GeometryFrame | undefined): Mesh | null {
  if (type >= Shape.hull) return geometry ? ofGeometry(geometry) : null;
  return ofKind(type, radius > 0);
}

/** Its triangles, for a soft body whose vertices come one by one. */
export function trianglesOf(geometry: GeometryFrame): Uint32Array { return geometry.indices; }

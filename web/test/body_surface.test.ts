import * as THREE from 'three';
import { describe, expect, it } from 'vitest';
import type { MechanismData } from '../src/core/protocol';
import { finish, make_body_surface, make_rough_surface, surfaces_ready, type BodySurface, type IndexRange } from '../src/view/body_surface';
import { BodyField, bind_poses, parts_of_body } from '../src/view/body_field';

type Link = { label: string; parent: number; at: [number, number, number]; shape: object };
const mechanism = (links: Link[]): MechanismData =>
  ({
    id: 'm', name: 'Body', dofs: 6, mass: 1, height: 1,
    links: links.map((l, i) => ({ name: `link ${i}`, label: l.label, parent: l.parent, joint: 'spherical', dofs: 3, neutral: [...l.at, 1, 0, 0, 0], shapes: [{ pose: [0, 0, 0, 1, 0, 0, 0], ...l.shape }] })),
  }) as unknown as MechanismData;

const radius = 0.1;
/** Spheres that do not touch each other. */
const spheres = mechanism(Array.from({ length: 8 }, (_, i) => ({ label: `part ${i}`, parent: i - 1, at: [0.5 * i, 0.1 * i, 0], shape: { type: 'sphere', radius } })));
/** A chain of equal capsules along z, each of which begins at the end of the previous one. */
const chain = mechanism(Array.from({ length: 8 }, (_, i) => ({ label: `part ${i} left`, parent: i - 1, at: [0, 0, 0.3 * i], shape: { type: 'capsule', radius, half_length: 0.15, pose: [0, 0, 0.15, 1, 0, 0, 0] } })));

await surfaces_ready;
const made = { spheres: make_body_surface(spheres)!, chain: make_body_surface(chain)! };
const points = (s: BodySurface): THREE.Vector3[] => {
  const p = s.geometry.getAttribute('position');
  return Array.from({ length: p.count }, (_, i) => new THREE.Vector3().fromBufferAttribute(p, i));
};
const indices = (s: BodySurface, { start, count }: IndexRange): Uint32Array => (s.geometry.index!.array as Uint32Array).slice(start, start + count);
/** Enclosed volume by the divergence theorem, m^3. */
function volume(s: BodySurface, range: IndexRange): number {
  const p = points(s);
  const index = indices(s, range);
  let out = 0;
  for (let i = 0; i < index.length; i += 3) out += p[index[i]!]!.dot(p[index[i + 1]!]!.clone().cross(p[index[i + 2]!]!)) / 6;
  return out;
}

describe('the surface of a body', () => {
  it('is a closed mesh whose normals point outwards', () => {
    for (const [body, range] of [made.spheres, made.chain].flatMap((b) => [b.shown, ...b.coarser, b.shadow].map((range) => [b, range] as const))) {
      const index = indices(body, range);
      const edges = new Map<string, number>();
      for (let i = 0; i < index.length; i += 3)
        for (let k = 0; k < 3; k++) {
          const [a, b] = [index[i + k]!, index[i + ((k + 1) % 3)]!];
          edges.set(`${a}>${b}`, (edges.get(`${a}>${b}`) ?? 0) + 1);
        }
      expect([...edges.keys()].filter((edge) => !edges.has(edge.split('>').reverse().join('>')))).toEqual([]);
      expect(volume(body, range)).toBeGreaterThan(0);
    }
  });

  it('draws links that are thinner than the cells of the grid as their shapes, each bound to its link', () => {
    const thin = 0.009; // m; a cell has 24 mm
    const finger = { label: '', parent: 7, at: [0.3, 0, 2.3] as [number, number, number] };
    const shapes = [
      { type: 'capsule', radius: thin, half_length: 0.03 },
      { type: 'ellipsoid', half_extents: [0.05, thin, thin] },
      { type: 'box', half_extents: [0.04, 0.03, thin] },
    ];
    // exact volumes of the capsule and the ellipsoid, m^3
    const exact = [Math.PI * thin ** 2 * 0.06 + (4 / 3) * Math.PI * thin ** 3, (4 / 3) * Math.PI * 0.05 * thin ** 2];
    const turned = { pose: [0.1, 0.02, 0, Math.cos(0.4), 0, Math.sin(0.4), 0] };
    shapes.forEach((shape, kind) => {
      const arm: Link[] = chain.links.map((l, i) => ({ label: l.label!, parent: i - 1, at: [0, 0, 0.3 * i], shape: l.shapes[0]! }));
      const hand = mechanism([...arm, { ...finger, shape: { ...shape, ...turned } }]);
      const surface = make_body_surface(hand)!;
      const [skin, weight, normal] = ['skinIndex', 'skinWeight', 'normal'].map((name) => surface.geometry.getAttribute(name));
      const p = points(surface);
      const to_part = new THREE.Matrix4().makeTranslation(0.4, 0.02, 2.3).multiply(new THREE.Matrix4().makeRotationFromQuaternion(new THREE.Quaternion(0, Math.sin(0.4), 0, Math.cos(0.4)))).invert();
      const field = new BodyField(hand, bind_poses(hand));
      for (const range of [surface.shown, ...surface.coarser, surface.shadow]) {
        const own = [...new Set(indices(surface, range))].filter((i) => skin!.getX(i) === 8);
        expect(own.length).toBeGreaterThan(15);
        for (const i of own) {
          expect(weight!.getX(i)).toBe(1);
          expect(Math.abs(field.link_distance(field.links[8]!, p[i]!.x, p[i]!.y, p[i]!.z))).toBeLessThan(2e-5);
          const e = 1e-5;
          const n = new THREE.Vector3().fromBufferAttribute(normal!, i);
          const out = p[i]!.clone().addScaledVector(n, e);
          expect(field.link_distance(field.links[8]!, out.x, out.y, out.z)).toBeGreaterThan(0.8 * e);
        }
        const triangles = [...indices(surface, range)];
        let enclosed = 0;
        for (let k = 0; k < triangles.length; k += 3) {
          if (skin!.getX(triangles[k]!) !== 8) continue;
          const [a, b, c] = triangles.slice(k, k + 3).map((i) => p[i]!.clone().applyMatrix4(to_part));
          enclosed += a!.dot(b!.clone().cross(c!)) / 6;
        }
        if (exact[kind]) expect(enclosed / exact[kind]).toBeGreaterThan(range === surface.shown ? 0.87 : 0.6);
        if (exact[kind]) expect(enclosed / exact[kind]).toBeLessThan(1);
        expect(enclosed).toBeGreaterThan(0);
      }
    });
  });

  it('has the shape of spheres that are not connected by overlap', () => {
    const surface = made.spheres;
    const centres = spheres.links.map((l) => new THREE.Vector3(...(l.neutral!.slice(0, 3) as [number, number, number])));
    const normal = surface.geometry.getAttribute('normal');
    points(surface).forEach((p, i) => {
      const nearest = centres.reduce((a, b) => (a.distanceTo(p) < b.distanceTo(p) ? a : b));
      expect(Math.abs(p.distanceTo(nearest) - radius)).toBeLessThan(5e-4);
      expect(new THREE.Vector3().fromBufferAttribute(normal, i).dot(p.clone().sub(nearest).normalize())).toBeGreaterThan(0.99);
    });
    const exact = 8 * (4 / 3) * Math.PI * radius ** 3;
    [surface.shown, ...surface.coarser].reduce((finer, level) => {
      expect(level.count).toBeLessThan(0.95 * finer.count);
      return level;
    });
    const deepest = (range: IndexRange): number => {
      const p = points(surface);
      const index = indices(surface, range);
      const depths = Array.from({ length: index.length / 3 }, (_, t) => {
        const middle = p[index[3 * t]!]!.clone().add(p[index[3 * t + 1]!]!).add(p[index[3 * t + 2]!]!).divideScalar(3);
        return radius - Math.min(...centres.map((c) => c.distanceTo(middle)));
      });
      return Math.max(...depths);
    };
    for (const level of surface.coarser) {
      expect(deepest(level)).toBeGreaterThan(deepest(surface.shown));
      expect(deepest(level)).toBeLessThan(deepest(surface.shown) + level.error);
    }
    expect(Math.abs(volume(surface, surface.coarser[0]!) / exact - 1)).toBeLessThan(0.17);
    expect(Math.abs(volume(surface, surface.shadow) / exact - 1)).toBeLessThan(0.24);
    expect(Math.abs(volume(surface, surface.shown) / exact - 1)).toBeLessThan(0.1); // facets of 1/100 of the body's length lie inside the spheres
  });

  it('has fewer triangles where it is flat, and stays near the zero level between the vertices', () => {
    // a chain with a long link in the middle
    const [first, length] = [0.6, 1.4]; // m
    const body = mechanism(
      Array.from({ length: 8 }, (_, i) => {
        const half = i === 3 ? length / 2 : 0.1;
        return { label: `part ${i} left`, parent: i - 1, at: [0, 0, i <= 3 ? 0.2 * i : first + length + 0.2 * (i - 4)] as [number, number, number], shape: { type: 'capsule', radius, half_length: half, pose: [0, 0, half, 1, 0, 0, 0] } };
      }),
    );
    const surface = make_body_surface(body)!;
    const field = new BodyField(body, bind_poses(body));
    const p = points(surface);
    const index = indices(surface, surface.shown);
    let [near, far] = [0, 0]; // triangles within 0.3 m of the joints of the long link, on this link, and the others on this link
    for (let i = 0; i < index.length; i += 3) {
      const centre = [0, 1, 2].reduce((sum, k) => sum.add(p[index[i + k]!]!), new THREE.Vector3()).divideScalar(3);
      expect(Math.abs(field.distance(centre.x, centre.y, centre.z))).toBeLessThan(4e-3); // cells are 29 mm wide: 1.4 mm without joined triangles
      const along = centre.z - first;
      if (along < 0 || along > length) continue;
      if (Math.min(along, length - along) < 0.3) near++;
      else far++;
    }
    expect(far / 0.8).toBeLessThan(0.5 * (near / 0.6)); // triangles per metre
    expect(surface.shadow.count).toBeLessThan(0.7 * surface.shown.count);
    expect(p.length).toBe(new Set(index).size); // no vertex without a triangle
  });

  it('encloses the shapes, and a limb is at most a quarter of its radius thicker at joints', () => {
    const surface = made.chain;
    for (const p of points(surface)) {
      const along = Math.max(0, Math.min(2.4, p.z));
      const away = Math.hypot(p.x, p.y, p.z - along);
      expect(away).toBeGreaterThan(radius - 1e-3);
      expect(away).toBeLessThan(1.25 * radius);
    }
  });

  it('follows the links by weights that are 1 in sum and belong to connected links', () => {
    const { geometry } = made.chain;
    const [links, weights] = [geometry.getAttribute('skinIndex'), geometry.getAttribute('skinWeight')];
    points(made.chain).forEach((p, i) => {
      const used = [0, 1, 2, 3].filter((k) => weights.getComponent(i, k) > 0);
      expect(used.reduce((sum, k) => sum + weights.getComponent(i, k), 0)).toBeCloseTo(1, 5);
      const used_links = used.map((k) => links.getComponent(i, k));
      expect(Math.max(...used_links) - Math.min(...used_links)).toBeLessThanOrEqual(2);
      // in the middle of a link, only this link acts
      const middle = (((p.z / 0.3) % 1) + 1) % 1;
      if (p.z > 0 && p.z < 2.4 && Math.abs(middle - 0.5) < 0.1) expect(used_links).toEqual([Math.floor(p.z / 0.3)]);
    });
  });

  it('is made for bodies only', () => {
    expect(make_body_surface(mechanism(chain.links.slice(0, 4).map((l) => ({ label: l.label ?? '', parent: l.parent, at: [0, 0, 0], shape: l.shapes[0]! }))))).toBeNull();
    expect(make_body_surface({ ...chain, links: chain.links.map((l) => ({ ...l, label: '' })) })).toBeNull();
  });

  it('leaves out a machine that carries the body, but not what the body carries', () => {
    const limbs = Array.from({ length: 9 }, (_, i) => ({ label: i === 8 ? '' : `part ${i}`, parent: i, at: [0.5 * i, 0, 1] as [number, number, number], shape: { type: 'sphere', radius } }));
    const machine = { label: '', parent: -1, at: [0, 0, -3] as [number, number, number], shape: { type: 'sphere', radius } };
    const both = mechanism([machine, { ...machine, parent: 0 }, ...limbs.map((l, i) => ({ ...l, parent: i === 0 ? 0 : l.parent + 1 }))]);
    expect(parts_of_body(both)).toEqual([false, false, ...limbs.map(() => true)]);
    const low = points(make_body_surface(both)!).map((p) => p.z);
    expect(low.length).toBeGreaterThan(100);
    expect(Math.min(...low)).toBeGreaterThan(0.5);
  });

  it('is made with legs apart', () => {
    const links: Link[] = [{ label: 'pelvis', parent: -1, at: [0, 0, 1], shape: { type: 'sphere', radius } }];
    for (const [side, y] of [['left', 0.1], ['right', -0.1]] as const) {
      links.push({ label: `thigh ${side}`, parent: 0, at: [0, y, 0.9], shape: { type: 'capsule', radius: 0.09, half_length: 0.2, pose: [0, 0, -0.2, 1, 0, 0, 0] } });
      links.push({ label: `shank ${side}`, parent: links.length - 1, at: [0, y, 0.5], shape: { type: 'sphere', radius: 0.06 } });
    }
    const poses = bind_poses(mechanism(links));
    const y = (i: number): number => new THREE.Vector3().setFromMatrixPosition(poses[i]!).y;
    expect(y(2)).toBeGreaterThan(0.15);
    expect(y(4)).toBeLessThan(-0.15);
    const field = new BodyField(mechanism(links), poses);
    expect(field.distance(0, 0, 0.5)).toBeGreaterThan(0.03);
  });

  it('has a lower bound of the distance from each link', () => {
    const shapes = [
      { type: 'sphere', radius: 0.07 },
      { type: 'capsule', radius: 0.04, half_length: 0.2 },
      { type: 'cylinder', radius: 0.05, half_length: 0.12 },
      { type: 'ellipsoid', half_extents: [0.05, 0.09, 0.06] },
      { type: 'box', half_extents: [0.1, 0.04, 0.02] },
    ];
    const body = mechanism(shapes.map((shape, i) => ({ label: `part ${i}`, parent: -1, at: [i, 0, 0], shape: { ...shape, pose: [0.01, 0.02, 0, 0.8, 0.6, 0, 0] } })));
    const field = new BodyField(body, bind_poses(body));
    let seed = 1;
    const random = (): number => (seed = (seed * 1103515245 + 12345) % 2 ** 31) / 2 ** 31 - 0.5;
    let [near, count] = [0, 0];
    for (const link of field.links)
      for (let i = 0; i < 2000; i++, count++) {
        const [x, y, z] = [link.centre.x + random(), link.centre.y + random(), link.centre.z + random()];
        const exact = field.link_distance(link, x, y, z);
        const lower = field.min_distance(link, x, y, z);
        if (exact > 0) expect(lower).toBeLessThan(1.3 * exact + 1e-9); // the field of an ellipsoid is up to 30 % below the distance
        if (exact - lower < 1.1 * link.radius) near++;
      }
    expect(near / count).toBeGreaterThan(0.8); // the bound is not far below the distance
  });

  it('considers near a point the same links as everywhere', () => {
    const field = new BodyField(chain, bind_poses(chain));
    const all = new BodyField(chain, bind_poses(chain));
    for (let i = 0; i < 200; i++) {
      const [x, y, z] = [0.15 * Math.sin(i), 0.15 * Math.cos(3 * i), 0.012 * i];
      field.look_near(x, y, z, 0.01);
      expect(field.distance(x + 0.005, y - 0.005, z + 0.005)).toBe(all.distance(x + 0.005, y - 0.005, z + 0.005));
    }
  });

  it('begins rough and becomes the same surface', () => {
    const { surface, refine } = make_rough_surface(chain)!;
    const { geometry } = surface;
    expect(surface.shown.count).toBeLessThan(0.4 * made.chain.shown.count);
    expect(surface.shown.count).toBeGreaterThan(0);
    let freed = 0;
    geometry.addEventListener('dispose', () => freed++);
    finish(refine);
    expect(freed).toBe(1);
    expect(surface.geometry).toBe(geometry);
    expect([surface.shown, surface.shadow]).toEqual([made.chain.shown, made.chain.shadow]);
    for (const name of ['position', 'normal', 'skinIndex', 'skinWeight']) expect(geometry.getAttribute(name).array).toEqual(made.chain.geometry.getAttribute(name).array);
    expect(geometry.index!.array).toEqual(made.chain.geometry.index!.array);
  });
});

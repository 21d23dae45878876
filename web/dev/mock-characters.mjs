// Characters of the mock service: bodies of capsules, spheres and boxes, moved by sine waves.

const qmul = (a, b) => [
  a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
  a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
  a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
  a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
];
const rotate = (q, v) => {
  const [w, x, y, z] = q;
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]];
};
const about = (axis, angle) => [Math.cos(angle / 2), ...axis.map((a) => a * Math.sin(angle / 2))];
const add = (a, b) => a.map((v, i) => v + b[i]);
const capsule = (radius, a, b) => {
  const d = b.map((v, i) => v - a[i]);
  const length = Math.hypot(...d) || 1e-9;
  const u = d.map((v) => v / length);
  const w = 1 + u[2];
  const q = w < 1e-6 ? [0, 1, 0, 0] : [w, -u[1], u[0], 0];
  const n = Math.hypot(...q);
  return { type: 'capsule', radius, half_length: length / 2, pose: [...add(a, b).map((v) => v / 2), ...q.map((v) => v / n)] };
};
const sphere = (radius, at) => ({ type: 'sphere', radius, pose: [...at, 1, 0, 0, 0] });
const box = (half_extents, at) => ({ type: 'box', half_extents, pose: [...at, 1, 0, 0, 0] });
const Y = [0, 1, 0];
const X = [1, 0, 0];
const Z = [0, 0, 1];

// A link is a list: name, index of the parent (null: no parent, the link is the root; -1: the previous link), offset from the parent (m),
// shapes, and a function that returns the joint's [axis, angle] for a gait phase.
// Phase and angle are in rad.
function human() {
  const leg = (side, s) => [
    [`${side}Thigh`, 0, [0, s * 0.095, -0.02], [capsule(0.07, [0, 0, -0.03], [0, 0, -0.36])], (p) => [Y, -0.42 * Math.sin(p + (s > 0 ? 0 : Math.PI)) - 0.08]],
    [`${side}Shin`, -1, [0, 0, -0.42], [capsule(0.048, [0, 0, -0.02], [0, 0, -0.37])], (p) => [Y, 0.15 + 0.5 * Math.max(0, Math.cos(p + (s > 0 ? 0 : Math.PI)))]],
    [`${side}Foot`, -1, [0, 0, -0.42], [box([0.115, 0.042, 0.032], [0.055, 0, -0.035])], (p) => [Y, 0.12 * Math.sin(p + (s > 0 ? 0 : Math.PI))]],
  ];
  const arm = (side, s) => [
    [`${side}UpperArm`, 2, [0, s * 0.19, 0.22], [capsule(0.042, [0, 0, -0.02], [0, 0, -0.26])], (p) => [Y, 0.45 * Math.sin(p + (s > 0 ? 0 : Math.PI))]],
    [`${side}Forearm`, -1, [0, 0, -0.29], [capsule(0.034, [0, 0, -0.01], [0, 0, -0.23])], () => [Y, -0.35]],
    [`${side}Hand`, -1, [0, 0, -0.26], [capsule(0.03, [0, 0, -0.02], [0, 0, -0.11])], () => [Y, 0]],
  ];
  return {
    id: 'm-human', name: 'Human 1.75 m', dofs: 62, mass: 70, height: 1.75, rest: 0.94, pace: 1.25, period: 1.1, gait: 'two',
    links: [
      ['Pelvis', null, [0, 0, 0], [capsule(0.1, [0, -0.07, 0.02], [0, 0.07, 0.02])], (p) => [X, 0.05 * Math.sin(p)]],
      ['Spine', 0, [0, 0, 0.1], [capsule(0.1, [0, -0.035, 0.06], [0, 0.035, 0.06])], (p) => [Z, 0.08 * Math.sin(p)]],
      ['Chest', 1, [0, 0, 0.16], [capsule(0.115, [0, -0.07, 0.12], [0, 0.07, 0.12])], (p) => [Z, 0.1 * Math.sin(p)]],
      ['Neck', 2, [0.01, 0, 0.27], [capsule(0.045, [0, 0, 0], [0, 0, 0.07])], () => [Y, 0.05]],
      ['Head', 3, [0.01, 0, 0.1], [capsule(0.083, [0.012, 0, 0.07], [0.0, 0, 0.125])], () => [Y, -0.05]],
      ...leg('Left', 1), ...leg('Right', -1), ...arm('Left', 1), ...arm('Right', -1),
    ],
  };
}

function dog() {
  const leg = (name, parent, x, s, phase) => [
    [`${name}Upper`, parent, [x, s * 0.085, -0.02], [capsule(0.045, [0, 0, 0], [0, 0, -0.2])], (p) => [Y, -0.45 * Math.sin(p + phase) + (x < -0.2 ? -0.25 : 0.1)]],
    [`${name}Lower`, -1, [0, 0, -0.24], [capsule(0.027, [0, 0, 0], [0, 0, -0.19])], (p) => [Y, (x < -0.2 ? 0.5 : -0.2) + 0.3 * Math.max(0, Math.cos(p + phase))]],
    [`${name}Paw`, -1, [0, 0, -0.22], [capsule(0.024, [0, 0, -0.01], [0.05, 0, -0.015])], () => [Y, 0]],
  ];
  return {
    id: 'm-dog', name: 'Dog, shepherd', dofs: 54, mass: 32, height: 0.62, rest: 0.5, pace: 1.6, period: 0.62, gait: 'four',
    links: [
      ['Trunk', null, [0, 0, 0], [capsule(0.115, [-0.26, 0, 0.03], [0.02, 0, 0.03])], (p) => [Y, 0.03 * Math.sin(2 * p)]],
      ['Chest', 0, [0.12, 0, 0.02], [capsule(0.125, [-0.05, 0, -0.01], [0.1, 0, 0])], () => [Y, 0.02]],
      ['Neck', 1, [0.16, 0, 0.06], [capsule(0.07, [0, 0, 0], [0.13, 0, 0.16])], (p) => [Y, 0.05 * Math.sin(2 * p)]],
      ['Head', 2, [0.16, 0, 0.2], [capsule(0.07, [0, 0, 0.02], [0.06, 0, 0.01]), capsule(0.042, [0.08, 0, -0.005], [0.19, 0, -0.03]), capsule(0.016, [-0.02, 0.045, 0.08], [-0.03, 0.05, 0.15]), capsule(0.016, [-0.02, -0.045, 0.08], [-0.03, -0.05, 0.15])], () => [Y, 0.1]],
      ['Tail', 0, [-0.36, 0, 0.09], [capsule(0.02, [0, 0, 0], [-0.22, 0, 0.12])], (p) => [Z, 0.3 * Math.sin(p)]],
      ...leg('FrontLeft', 1, 0.08, 1, 0), ...leg('FrontRight', 1, 0.08, -1, Math.PI),
      ...leg('HindLeft', 0, -0.28, 1, Math.PI), ...leg('HindRight', 0, -0.28, -1, 0),
    ],
  };
}

function ball() {
  return { id: 'm-ball', name: 'Ball', dofs: 6, mass: 2.5, height: 0.3, rest: 0.15, pace: 0, period: 1, gait: 'none', links: [['Ball', null, [0, 0, 0], [sphere(0.15, [0, 0, 0])], () => [Y, 0]]] };
}

const raw = [human(), dog(), ball()];

/** The bodies, with parents as link indices (-1: root). */
export const bodies = raw.map((body) => ({
  ...body,
  links: body.links.map(([name, parent, offset, shapes, angle], i) => ({ name, parent: parent === null ? -1 : parent === -1 ? i - 1 : parent, offset, shapes, angle })),
}));

/**
 * World poses of all links, flat: position (m) and quaternion (w, x, y, z) of each.
 * @param root x, y, z in m and heading in rad; @param phase gait phase, rad; @param amount scale of the joint angles, 0: neutral pose
 * @param lean tilt of the root about Y and X and bend of its children about Y, rad
 */
export function place(body, root, phase, amount, lean = [0, 0, 0]) {
  const heading = about(Z, root.heading);
  const poses = [];
  const out = [];
  body.links.forEach((link, i) => {
    const [axis, value] = link.angle(phase);
    const turn = about(axis, value * amount);
    if (link.parent < 0) {
      const tilt = qmul(about(Y, lean[0]), about(X, lean[1]));
      poses.push({ p: [root.x, root.y, root.z + body.rest + 0.02 * amount * Math.cos(2 * phase)], q: qmul(heading, qmul(tilt, turn)) });
    } else {
      const up = poses[link.parent];
      const bend = i > 0 && link.parent === 0 ? about(Y, -lean[2]) : [1, 0, 0, 0];
      poses.push({ p: add(up.p, rotate(up.q, link.offset)), q: qmul(up.q, qmul(bend, turn)) });
    }
    out.push(...poses[i].p, ...poses[i].q);
  });
  return out;
}

export function mechanism_json(body) {
  const neutral = place(body, { x: 0, y: 0, z: 0, heading: 0 }, 0, 0);
  return {
    id: body.id, name: body.name, dofs: body.dofs, mass: body.mass, height: body.height,
    links: body.links.map((l, i) => ({
      name: l.name, label: l.name.replace(/([a-z])([A-Z])/g, '$1 $2').replace(/ [A-Z]/g, (m) => m.toLowerCase()), parent: l.parent,
      joint: l.parent < 0 ? 'floating' : 'spherical', dofs: l.parent < 0 ? 6 : 3, shapes: l.shapes, neutral: neutral.slice(7 * i, 7 * i + 7),
    })),
  };
}

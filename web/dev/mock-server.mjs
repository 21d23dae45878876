// A mock service that implements a part of docs/studio-protocol.md with invented characters: for work on the page without the program.
//   node dev/mock-server.mjs [port]      serves web/dist and prints the address
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { WebSocketServer } from 'ws';
import { apply_circuit_edit, execution, lsis, many_lsis, values_event } from './mock-circuit.mjs';
import { bodies, mechanism_json, place } from './mock-characters.mjs';

const dist = fileURLToPath(new URL('../dist/', import.meta.url));
const token = 'mock';
const port = Number(process.argv[2] ?? 7117);
const types = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.json': 'application/json' };

const curve = (f) => Array.from({ length: 40 }, (_, i) => 0.5 + 0.45 * f(i / 39));
const motions = [
  { id: 'n-stand', kind: 'motion', name: 'stand', mechanism: 'm-human', duration: 2, rate: 120, frames: 240, cyclic: true, pace: 0, curve: curve((t) => 0.15 * Math.sin(6 * t)) },
  { id: 'n-walk', kind: 'motion', name: 'walk, relaxed', mechanism: 'm-human', duration: 4.4, rate: 120, frames: 528, cyclic: true, pace: 1, curve: curve((t) => Math.sin(14 * t)), tags: ['gait'], summary: 'Made from published gait curves' },
  { id: 'n-turn', kind: 'motion', name: 'turn left 90°', mechanism: 'm-human', duration: 1.9, rate: 120, frames: 228, cyclic: false, pace: 0.6, turn: Math.PI / 2, curve: curve((t) => Math.sin(7 * t) * (1 - t)) },
  { id: 'n-trot', kind: 'motion', name: 'trot', mechanism: 'm-dog', duration: 0.62, rate: 120, frames: 74, cyclic: true, pace: 1, curve: curve((t) => Math.sin(9 * t)) },
];
const library = [
  ...bodies.map((b) => ({ id: b.id, kind: 'mechanism', name: b.name, dofs: b.dofs, mass: b.mass, height: b.height, tags: [] })),
  ...motions.map(({ pace: _p, turn: _t, ...m }) => m),
];
const clip = (id, motion, start, length, more = {}) => ({ id, motion, start, length, offset: 0, speed: 1, blend: 0.3, loop: false, ...more });
const control = { mode: 'track', tracking: 1.2, balance: 1, assist_limit: 0.3, beyond: 'release' };
let doc = {
  version: 1, name: 'park', duration: 12, frame_rate: 60, step: 0.002, gravity: [0, 0, -9.81], ground: { height: 0, friction: 0.9, restitution: 0 },
  characters: [
    { id: 'human', name: 'Human', mechanism: 'm-human', color: '#e6e6ea', place: { x: 0, y: 0, z: 0, heading: 0 }, control,
      track: [clip('k1', 'n-stand', 0, 1.2), clip('k2', 'n-walk', 1.0, 4.4), clip('k3', 'n-turn', 5.1, 1.9), clip('k4', 'n-walk', 6.8, 4.4, { speed: 1.1 })] },
    { id: 'dog', name: 'Dog', mechanism: 'm-dog', color: '#c99f74', place: { x: 0.4, y: -1.3, z: 0, heading: 8 }, control, track: [clip('k5', 'n-trot', 0.5, 7, { loop: true })] },
    { id: 'ball', name: 'Ball', mechanism: 'm-ball', color: '#ff9d4d', place: { x: 2.6, y: 0.7, z: 0, heading: 0 }, control: { ...control, mode: 'passive' }, track: [] },
  ],
  events: [
    { id: 'e1', type: 'push', time: 3.4, duration: 0.2, character: 'human', link: 'Chest', force: [150, 0, 0] },
    { id: 'e2', type: 'throw', time: 5.2, character: 'ball', from: [3, 0, 1.2], velocity: [-6, 0, 2], spin: [0, 0, 0] },
  ],
  camera: { follow: 'human', distance: 5.6, azimuth: 0.75, elevation: 0.2 }, look: { light: 0.9, floor: '#2a2c31' }, circuit: null,
};
// UGOKI_MOCK_LSIS=n: serves a circuit of n LSIs instead of the execution circuit, to test the editor with a large circuit
const many = Number(process.env.UGOKI_MOCK_LSIS ?? 0);
const circuit = many > 0 ? many_lsis(many) : execution();

let revision = 1;
let unsaved = false;
let choices = {};
const past = [];
const future = [];
let transport = { mode: 'edit', playing: false, speed: 1, time: 0, simulated: 0 };
let watched = null;
let grab = null;
let pulled = 0;
const clients = new Set();

const refuse = (message, remedy, location = '') => ({ error: { problems: [{ code: 'refused', location, message, remedy }] } });
const label_of = (c) => (c.type === 'group' || c.type === 'circuit.edit' ? c.label : { 'clip.set': 'Change clip', 'clip.add': 'Add clip', 'clip.remove': 'Delete clip', 'clip.split': 'Split clip', 'event.set': 'Change event' }[c.type] ?? c.type);

function apply(d, c) {
  const out = structuredClone(d);
  const character = (id) => out.characters.find((x) => x.id === id) ?? (() => { throw refuse(`There is no character “${id}”.`, 'Select a character of the scenario.', 'characters'); })();
  const track_clip = () => character(c.character).track.find((k) => k.id === c.id) ?? (() => { throw refuse(`There is no clip “${c.id}”.`, 'It may have been deleted; undo brings it back.', c.character); })();
  const { type, ...fields } = c;
  if (type === 'clip.set') {
    const { character: _c, id: _i, ...rest } = fields;
    Object.assign(track_clip(), rest);
    if (rest.speed !== undefined && rest.speed <= 0) throw refuse('The speed must be above 0.', 'Enter a speed of 0.1 or more.', `track/${c.id}/speed`);
  } else if (type === 'clip.add') {
    const m = motions.find((x) => x.id === c.motion);
    if (!m) throw refuse(`There is no motion “${c.motion}”.`, 'Import it first.', 'motion');
    const { character: id, ...rest } = fields;
    character(id).track.push({ id: `k${Date.now() % 100000}`, length: m.duration, offset: 0, speed: 1, blend: 0.3, loop: false, ...rest });
  } else if (type === 'clip.remove') character(c.character).track = character(c.character).track.filter((k) => k.id !== c.id);
  else if (type === 'clip.split') {
    const k = track_clip();
    const first = c.time - k.start;
    character(c.character).track.push({ ...k, id: `k${Date.now() % 100000}`, start: c.time, length: k.length - first, offset: k.offset + first * k.speed, blend: 0 });
    k.length = first;
  } else if (type === 'character.add') out.characters.push({ id: `c${Date.now() % 1e5}`, name: 'New', color: '#e6e6ea', track: [], ...fields, place: { x: 0, y: 0, z: 0, heading: 0, ...fields.place }, control: { ...control, ...fields.control } });
  else if (type === 'character.set') {
    const x = character(c.id);
    Object.assign(x, { ...fields, place: { ...x.place, ...fields.place }, control: { ...x.control, ...fields.control } });
  } else if (type === 'character.remove') out.characters = out.characters.filter((x) => x.id !== c.id);
  else if (type === 'event.add') out.events.push({ id: `e${Date.now() % 1e5}`, ...c.event });
  else if (type === 'event.set') Object.assign(out.events.find((e) => e.id === c.id), c.event);
  else if (type === 'event.remove') out.events = out.events.filter((e) => e.id !== c.id);
  else if (type === 'scenario.set') Object.assign(out, fields);
  else if (type === 'circuit.set') out.circuit = c.circuit;
  else if (type === 'circuit.edit') out.circuit = apply_circuit_edit(out.circuit ?? circuit, c.changes);
  else if (type === 'group') return c.commands.reduce(apply, out);
  else throw refuse(`The command “${type}” is not known.`, 'Update the page.', 'type');
  for (const x of out.characters) x.track.sort((a, b) => a.start - b.start);
  return out;
}

const body_of = (c) => bodies.find((b) => b.id === c.mechanism);
const document_state = () => ({
  document: doc, ...(doc.circuit ? {} : { generated_circuit: circuit }), revision, can_undo: past.length > 0, can_redo: future.length > 0, undo_label: past.at(-1)?.label ?? '', redo_label: future.at(-1)?.label ?? '',
  characters: doc.characters.map((c) => ({ id: c.id, name: c.name, mechanism: c.mechanism, links: body_of(c).links.length })),
});
const transport_state = () => ({ ...transport, duration: doc.duration, steps_per_s: 19000, realtime_factor: 38, status: 'ok' });
const broadcast = (event) => { for (const c of clients) c.send(JSON.stringify(event)); };
const changed = () => { revision++; unsaved = true; broadcast({ event: 'document', unsaved, ...document_state() }); send_frame(); };
const send_transport = () => broadcast({ event: 'transport', ...transport_state() });

function root_at(character, time) {
  const body = body_of(character);
  const root = { x: character.place.x, y: character.place.y, z: character.place.z, heading: (character.place.heading * Math.PI) / 180 };
  let phase = 0;
  let amount = 0;
  for (let t = 0; t < time; t += 1 / 60) {
    const k = character.track.findLast((x) => t >= x.start && t < x.start + x.length);
    const m = k && motions.find((x) => x.id === k.motion);
    const pace = m ? m.pace * k.speed : 0;
    amount += (Math.min(1, pace) - amount) * 0.08;
    phase += ((2 * Math.PI) / body.period / 60) * pace;
    if (m?.turn) root.heading += (m.turn / m.duration / 60) * k.speed;
    root.x += (Math.cos(root.heading) * body.pace * pace) / 60;
    root.y += (Math.sin(root.heading) * body.pace * pace) / 60;
  }
  return { root, phase, amount };
}

function frame_bytes() {
  const simulate = transport.mode === 'simulate';
  const parts = doc.characters.map((c) => {
    const body = body_of(c);
    const { root, phase, amount } = root_at(c, transport.time);
    const held = grab && grab.character === c.id;
    if (c.id === 'ball' && simulate && transport.time > 5.2) {
      const t = Math.min(transport.time - 5.2, 1.1);
      Object.assign(root, { x: 3 - 6 * t, y: 0, z: Math.max(0, 1.05 + 2 * t - 4.9 * t * t) });
    }
    let poses = place(body, root, phase, amount, held ? [0.06, 0.04, 0.05] : [0, 0, 0]);
    if (held) {
      const at = 7 * grab.link;
      pulled = Math.min(1, pulled + 0.08);
      const d = [0, 1, 2].map((i) => (grab.target[i] - poses[at + i] - grab.point[i]) * 0.6 * pulled);
      grab.at = [0, 1, 2].map((i) => poses[at + i] + grab.point[i] + d[i]);
      poses = poses.map((v, i) => (i % 7 < 3 ? v + d[i % 7] * (Math.floor(i / 7) === grab.link ? 1 : 0.25) : v));
    }
    const weight = body.mass * 9.81;
    const assist = simulate && c.control.mode === 'track' ? weight * (0.03 + 0.025 * Math.sin(3 * transport.time) + (held ? 0.12 : 0)) : 0;
    const state = !simulate ? 3 : c.control.mode === 'passive' ? 2 : c.id === 'human' && transport.time > 10 ? 1 : 0;
    return { body, poses, phase, header: [assist * 0.25, 0, state === 1 ? 0 : assist, 0, 0, 0, assist / (weight * c.control.assist_limit), weight, poses[0], poses[1], poses[2], 0], state };
  });
  const contacts = [];
  if (simulate) {
    parts.forEach((p, i) => p.body.links.forEach((l, j) => {
      if (/Foot|Paw/.test(l.name) && p.poses[7 * j + 2] < 0.13) contacts.push([p.poses[7 * j], p.poses[7 * j + 1], 0, 20, 5, p.header[7] * (p.body.gait === 'four' ? 0.4 : 0.8), i, j]);
    }));
  }
  const size = 64 + parts.reduce((s, p) => s + 56 + p.poses.length * 4, 0) + contacts.length * 32;
  const view = new DataView(new ArrayBuffer(size));
  const u = (at, v) => view.setUint32(at, v, true);
  u(0, 0x46474b55); u(4, 1);
  view.setFloat64(8, transport.time, true);
  u(16, Math.round(transport.time * doc.frame_rate));
  u(20, (transport.playing ? 1 : 0) | (simulate ? 2 : 0) | (simulate && transport.time >= transport.simulated ? 4 : 0) | (grab ? 8 : 0));
  u(24, parts.length); u(28, contacts.length);
  if (grab) [...grab.at, ...grab.target].forEach((v, i) => view.setFloat32(32 + 4 * i, v, true));
  let at = 64;
  for (const p of parts) {
    u(at, p.poses.length / 7); u(at + 4, p.state);
    p.header.forEach((v, i) => view.setFloat32(at + 8 + 4 * i, v, true));
    at += 56;
    for (const v of p.poses) { view.setFloat32(at, v, true); at += 4; }
  }
  for (const c of contacts) { c.slice(0, 6).forEach((v, i) => view.setFloat32(at + 4 * i, v, true)); u(at + 24, c[6]); u(at + 28, c[7]); at += 32; }
  return Buffer.from(view.buffer);
}
const send_frame = () => { const bytes = frame_bytes(); for (const c of clients) if (c.bufferedAmount < 1e6) c.send(bytes); };

function summary() {
  const contacts = [];
  for (const c of doc.characters) {
    const body = body_of(c);
    if (body.gait === 'none') continue;
    for (let t = 0; t < transport.simulated; t += body.period / 4) {
      const walking = c.track.some((k) => t >= k.start && t < k.start + k.length && k.motion !== 'n-stand');
      contacts.push({ character: c.id, from: t, to: Math.min(transport.simulated, t + body.period / 4), feet: !walking ? 2 : Math.round(t / (body.period / 4)) % 2 ? 1 : body.gait === 'four' && Math.round(t * 7) % 5 === 0 ? 0 : 2 });
    }
  }
  broadcast({ event: 'summary', contacts, characters: doc.characters.map((c, i) => ({ id: c.id, assist_rms_bw: 0.041 + i * 0.02, foot_skate_cm: 0.6 + 0.9 * i, tracking_rms_deg: 1.9 + i, penetration_mm: 2.1, fell: false })) });
}

const operations = {
  hello: () => ({ project: { path: 'park.ugoki', name: 'park.ugoki', unsaved }, ...document_state(), transport: transport_state(), choices, circuit_problems: [], lsis }),
  command: ({ command }) => { const next = apply(doc, command); past.push({ doc, label: label_of(command) }); future.length = 0; doc = next; changed(); },
  undo: () => { const p = past.pop(); if (!p) throw refuse('There is nothing to undo.', ''); future.push({ doc, label: p.label }); doc = p.doc; changed(); },
  redo: () => { const p = future.pop(); if (!p) throw refuse('There is nothing to redo.', ''); past.push({ doc, label: p.label }); doc = p.doc; changed(); },
  remember: (request) => { choices = request.choices; },
  save: () => { unsaved = false; broadcast({ event: 'document', unsaved, ...document_state() }); },
  mode: ({ mode }) => { transport = { ...transport, mode, playing: false, simulated: mode === 'simulate' ? transport.time : 0 }; send_transport(); send_frame(); },
  play: ({ speed }) => { transport = { ...transport, playing: true, speed: speed ?? transport.speed, time: transport.time >= doc.duration ? 0 : transport.time }; send_transport(); },
  pause: () => { transport.playing = false; send_transport(); send_frame(); },
  step: ({ frames }) => { transport.playing = false; transport.time = Math.max(0, transport.time + frames / doc.frame_rate); send_transport(); send_frame(); },
  seek: ({ time }) => { transport.time = time; send_transport(); send_frame(); },
  restart: () => { transport = { ...transport, time: 0, simulated: 0, playing: true }; send_transport(); send_frame(); },
  grab: (r) => { grab = r; pulled = 0; },
  drag: ({ target }) => { if (grab) grab.target = target; },
  release: () => { grab = null; },
  push: () => undefined,
  watch: (request) => { watched = request; broadcast(values_event(watched, transport.time)); },
};

const server = createServer(async (request, response) => {
  const url = new URL(request.url, 'http://x');
  const json = (status, body) => response.writeHead(status, { 'content-type': 'application/json' }).end(JSON.stringify(body));
  if (url.pathname === '/api/session') return json(200, { token });
  if (url.pathname === '/api/library') return json(200, { entries: library });
  if (url.pathname.startsWith('/api/mechanism/')) {
    const body = bodies.find((b) => b.id === decodeURIComponent(url.pathname.slice(15)));
    return body ? json(200, mechanism_json(body)) : json(404, refuse('There is no such mechanism.', 'Choose a mechanism of the library.'));
  }
  if (url.pathname === '/api/import') {
    const name = url.searchParams.get('name');
    if (!/\.(bvh|asf|amc|json)$/i.test(name)) return json(400, refuse('The file format is not supported.', 'Import a BVH, ASF, AMC or mechanism file.', `${name}:1`));
    return json(200, { entries: [], report: ['31 joints, 523 frames at 120 Hz, 4.36 s', 'height 1.74 m; units taken as 0.45 inch', 'floor at −0.003 m moved to 0'] });
  }
  const path = normalize(url.pathname === '/' ? '/index.html' : url.pathname);
  try {
    const bytes = await readFile(join(dist, path));
    response.writeHead(200, { 'content-type': types[extname(path)] ?? 'application/octet-stream' }).end(bytes);
  } catch {
    response.writeHead(404).end('not found');
  }
});
const sockets = new WebSocketServer({ server, path: '/ws' });
sockets.on('connection', (socket) => {
  clients.add(socket);
  socket.on('close', () => clients.delete(socket));
  socket.on('message', (data) => {
    const request = JSON.parse(data);
    try {
      const reply = operations[request.op](request) ?? {};
      socket.send(JSON.stringify({ reply: request.id, ok: true, ...reply }));
      if (request.op === 'hello') send_frame();
    } catch (error) {
      socket.send(JSON.stringify({ reply: request.id, ok: false, ...(error.error ? error : refuse(String(error), '')) }));
    }
  });
});
let ticks = 0;
setInterval(() => {
  if (!transport.playing) return;
  transport.time += transport.speed / 60;
  if (transport.time >= doc.duration) { transport.time = doc.duration; transport.playing = false; send_transport(); }
  if (transport.mode === 'simulate') transport.simulated = Math.max(transport.simulated, transport.time);
  send_frame();
  if (watched && ticks % 4 === 0) broadcast(values_event(watched, transport.time));
  if (++ticks % 30 === 0) send_transport();
  if (ticks % 20 === 0 && transport.mode === 'simulate') summary();
}, 1000 / 60);
server.listen(port, '127.0.0.1', () => console.log(`http://127.0.0.1:${server.address().port}/#code=${token}`));

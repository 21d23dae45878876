// Circuits of the mock service: LSI (component) classes, an execution circuit, a large circuit, and invented values of outputs.
const pin = (name, type = 'scalar', more = {}) => ({ name, type, unit: '', doc: '', ...more });
const lsi = (name, doc, inputs, outputs, parameters = []) => ({
  name, doc, group: '', from: '', version: 1,
  inputs: inputs.map((p) => (typeof p === 'string' ? pin(p, 'scalar', { required: true, direct: true, multiple: false }) : { required: true, direct: true, multiple: false, ...p })),
  outputs: outputs.map((p) => (typeof p === 'string' ? pin(p, 'scalar', { delayed: false }) : { delayed: false, ...p })),
  parameters,
});
const number = (name, initial, more = {}) => ({ name, kind: 'number', initial, unit: '', doc: '', choices: [], live: true, ...more });

export const lsis = {
  pin_types: [],
  classes: [
    lsi('constant', 'A constant number.', [], ['out'], [number('value', 0)]),
    lsi('clock', 'The time of this tick.', [], [pin('time', 'scalar', { unit: 's' })]),
    lsi('add', 'a + b.', ['a', 'b'], ['out']),
    lsi('gain', 'Input times a factor.', ['in'], ['out'], [number('gain', 1, { doc: 'The factor.' })]),
    lsi('low-pass', 'First-order filter: follows its input with a time constant.', ['in'], ['out'], [number('time', 0.1, { minimum: 0, maximum: 10, unit: 's' })]),
    lsi('delay', 'The value of the previous tick; breaks algebraic loops.', [pin('in', 'scalar', { direct: false })], [pin('out', 'scalar', { delayed: true })]),
    lsi('make vector', 'A vector from its components.', ['x', 'y', 'z'], [pin('out', 'vector')]),
    lsi('split vector', 'The components of a vector.', [pin('in', 'vector')], ['x', 'y', 'z']),
    lsi('event', 'The events that act now.', [pin('live', 'event', { required: false })], [pin('events', 'event')]),
    lsi('motion retrieval', 'The clips that play now.', [], [pin('current', 'motion'), pin('previous', 'motion'), pin('blend')]),
    lsi('interpolation', 'Blends two motions.', [pin('current', 'motion'), pin('previous', 'motion'), 'blend'], [pin('reference', 'motion')]),
    lsi('motion control', 'Torques that follow the reference.', [pin('state', 'state'), pin('reference', 'motion'), pin('contacts', 'contacts')], [pin('torque', 'joint values', { unit: 'N m' }), pin('assist force', 'vector', { unit: 'N' }), pin('report', 'joint values')], [number('tracking', 1, { minimum: 0, maximum: 2 })]),
    lsi('collision analysis', 'Contacts between links.', [pin('state', 'state')], [pin('contacts', 'contacts')]),
    lsi('dynamics', 'One step of dynamics.', [pin('state', 'state', { direct: false }), pin('contacts', 'contacts'), pin('events', 'event'), pin('torque', 'joint values', { multiple: true })], [pin('next', 'state'), pin('contacts', 'contacts')]),
    lsi('status', 'The state.', [pin('next', 'state', { direct: false })], [pin('state', 'state', { delayed: true })]),
    lsi('display', 'The poses that are shown.', [pin('state', 'state')], [pin('poses', 'pose')]),
  ],
};

export function execution() {
  const at = { event: [0, 40], retrieval: [0, 200], interpolation: [240, 180], status: [1200, 140], collision: [480, 420], control: [480, 120], dynamics: [820, 160], display: [1480, 160] };
  const types = { event: 'event', retrieval: 'motion retrieval', interpolation: 'interpolation', status: 'status', collision: 'collision analysis', control: 'motion control', dynamics: 'dynamics', display: 'display' };
  return {
    version: 1, name: 'execution',
    inputs: [{ name: 'live', type: 'event', to: 'event.live' }],
    outputs: [{ name: 'state', type: 'state', from: 'status.state' }, { name: 'poses', type: 'pose', from: 'display.poses' }],
    lsis: Object.entries(types).map(([id, type]) => ({ id, type, at: at[id] })),
    wires: ['retrieval.current > interpolation.current', 'retrieval.previous > interpolation.previous', 'retrieval.blend > interpolation.blend', 'interpolation.reference > control.reference', 'status.state > control.state', 'collision.contacts > control.contacts', 'status.state > collision.state', 'collision.contacts > dynamics.contacts', 'status.state > dynamics.state', 'event.events > dynamics.events', 'control.torque > dynamics.torque', 'dynamics.next > status.next', 'status.state > display.state'].map((w) => { const [from, to] = w.split(' > '); return { from, to }; }),
  };
}

export function many_lsis(n) {
  const columns = Math.ceil(Math.sqrt(n / 2));
  return {
    version: 1, name: 'many',
    lsis: Array.from({ length: n }, (_, i) => ({ id: `g${i}`, type: i % 7 === 3 ? 'add' : i % 11 === 5 ? 'low-pass' : 'gain', at: [(i % columns) * 260, Math.floor(i / columns) * 120] })),
    wires: Array.from({ length: n - 1 }, (_, i) => ({ from: `g${i}.out`, to: `g${i + 1}.${(i + 1) % 7 === 3 ? 'a' : 'in'}` })),
  };
}

const key_of = (list, item) => (typeof item === 'string' ? item : list === 'wires' ? `${item.from}\n${item.to}` : list === 'probes' ? item.pin : (item.id ?? item.name));
export function apply_circuit_edit(before, changes) {
  const circuit = structuredClone(before);
  for (const change of changes) {
    let at = circuit;
    for (const name of change.in ?? []) at = at.circuits.find((c) => c.name === name);
    if (change.set) {
      for (const [k, v] of Object.entries(change.set)) if (v === null) delete at[k]; else at[k] = v;
      continue;
    }
    const items = (at[change.list] ??= []);
    const index = items.findIndex((item) => key_of(change.list, item) === key_of(change.list, change.put ?? change.take));
    if (change.take) items.splice(index, 1);
    else if (index < 0) items.push(change.put);
    else items[index] = change.put;
  }
  return circuit;
}

export function values_event(watched, time) {
  const wave = (name, i) => Math.sin(time * (1 + (name.length % 5)) + i) * (1 + name.length);
  return {
    event: 'values', time,
    pins: watched.pins.map((name) => [name, /state|torque/.test(name) ? 62 : 1, /contacts|event/.test(name) ? [Math.round(1 + Math.abs(wave(name, 0)) / 9)] : /torque|state|motion/.test(name) ? [0, 1, 2, 3].map((i) => wave(name, i)) : [wave(name, 0)]]),
    times: watched.timing ? [...new Set(watched.pins.map((p) => p.split('.')[0]))].map((id) => [id, 0.2 + (id.length % 7) * 3.1]) : undefined,
    tick_us: 39.1,
    probes: watched.probes.map((name) => [name, [time], [[wave(name, 0)], [wave(name, 2)]]]),
  };
}

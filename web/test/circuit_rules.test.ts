import text from './rule_circuit.json?raw';
import { describe, expect, it } from 'vitest';
import { keep_wired, wired_rules } from '../src/core/circuit_rules';
import type { Circuit, Lsi } from '../src/core/circuit/form';
import { apply_command, type ScenarioDocument } from '../src/core/document';

/** A document with rules of every kind, and the circuit that the service generates from it (tests/content/rules_test.cpp compares them). */
const sample = JSON.parse(text) as { document: ScenarioDocument; circuit: Circuit };
const { document: doc } = sample;
const copy = (): Circuit => structuredClone(sample.circuit);
const lsi = (circuit: Circuit, id: string): Lsi => circuit.lsis!.find((l) => l.id === id)!;
const state_of = (circuit: Circuit, id: string): string => wired_rules(circuit, doc).find((w) => w.id === id)!.state;

describe('rules of a circuit of the project', () => {
  it('are those of the document while the circuit is as it was generated', () => {
    const wired = wired_rules(sample.circuit, doc);
    expect(wired.map((w) => w.id)).toEqual(doc.rules!.filter((r) => r.on).map((r) => r.id));
    expect(wired.filter((w) => w.state !== 'same')).toEqual([]);
  });

  it('change with the parameters of their LSIs', () => {
    const circuit = copy();
    lsi(circuit, 'rule-r1-1').parameters!.key = 'KeyU';
    lsi(circuit, 'rule-r4').values!.force = [1, 2, 3];
    lsi(circuit, 'rule-r4').parameters!.duration = 0;
    const wired = wired_rules(circuit, doc);
    expect(wired.filter((w) => w.state === 'changed').map((w) => w.id)).toEqual(['r1', 'r4']);
    expect(wired[0]!.rule).toMatchObject({ mode: 'while', if: [{ type: 'key', key: 'KeyU' }, { type: 'key', key: 'ShiftLeft', not: true }], do: { type: 'play', motion: doc.rules![0]!.do.type === 'play' ? doc.rules![0]!.do.motion : '' } });
    expect(wired.find((w) => w.id === 'r4')!.rule).toMatchObject({ mode: 'while', do: { type: 'push', force: [1, 2, 3] } });
  });

  it('change with their wires', () => {
    const circuit = copy();
    // r11 grips while S is pressed instead of X: the keyboard of r2
    const wire = circuit.wires!.find((w) => w.to === 'rule-r11.when')!;
    wire.from = 'rule-r2-2.pressed';
    expect(wired_rules(circuit, doc).find((w) => w.id === 'r11')).toMatchObject({ state: 'changed', rule: { if: [{ type: 'key', key: 'KeyS' }] } });
    wire.from = 'rule-r1-2-not.out';
    expect(wired_rules(circuit, doc).find((w) => w.id === 'r11')).toMatchObject({ state: 'changed', rule: { if: [{ type: 'key', key: 'ShiftLeft', not: true }] } });
  });

  it('are edited in the circuit where no sentence has their form', () => {
    const circuit = copy();
    circuit.lsis!.push({ id: 'gain', type: 'gain', parameters: { factor: 2 } });
    circuit.wires!.push({ from: 'rule-r11-1.pressed', to: 'gain.in' });
    circuit.wires!.find((w) => w.to === 'rule-r11.when')!.from = 'gain.out';
    expect(state_of(circuit, 'r11')).toBe('own');
    // a force that is computed
    circuit.wires!.push({ from: 'gain.out', to: 'rule-r4.force' });
    expect(state_of(circuit, 'r4')).toBe('own');
    // an LSI that is gone, and one without a condition
    circuit.lsis = circuit.lsis!.filter((l) => l.id !== 'rule-r3');
    circuit.wires = circuit.wires!.filter((w) => w.to !== 'rule-r5.when');
    expect(state_of(circuit, 'r3')).toBe('missing');
    expect(state_of(circuit, 'r5')).toBe('own');
    expect(state_of(circuit, 'r10')).toBe('same');
  });

  it('are read from LSIs that the user added', () => {
    const circuit = copy();
    circuit.lsis!.push({ id: 'kick', type: 'push', parameters: { character: 'ball', link: '', duration: 0.3 }, values: { force: [0, 0, 9] } }, { id: 'k', type: 'keyboard', parameters: { key: 'KeyB' } });
    circuit.wires!.push({ from: 'k.pressed', to: 'kick.when' });
    expect(wired_rules(circuit, doc).at(-1)).toEqual({
      id: 'kick', state: 'changed', known: false,
      rule: { id: 'kick', on: true, mode: 'when', if: [{ type: 'key', key: 'KeyB' }], do: { type: 'push', character: 'ball', link: '', force: [0, 0, 9], duration: 0.3 } },
    });
  });

  it('end in circuits whose wires form a ring', () => {
    const circuit = copy();
    const ring = ['a', 'b'].map((id): Lsi => ({ id: `ring-${id}`, type: 'not' }));
    circuit.lsis!.push(...ring);
    circuit.wires!.push({ from: 'ring-a.out', to: 'ring-b.in' }, { from: 'ring-b.out', to: 'ring-a.in' });
    circuit.wires!.find((w) => w.to === 'rule-r11.when')!.from = 'ring-a.out';
    expect(state_of(circuit, 'r11')).toBe('own');
    const and = copy();
    and.lsis!.push({ id: 'loop', type: 'and' });
    and.wires!.push({ from: 'loop.out', to: 'loop.a' }, { from: 'rule-r11-1.pressed', to: 'loop.b' });
    and.wires!.find((w) => w.to === 'rule-r11.when')!.from = 'loop.out';
    expect(state_of(and, 'r11')).toBe('own');
  });
});

describe('keeping the rules of a circuit', () => {
  it('changes, adds and removes rules, and drops the circuit', () => {
    const circuit = copy();
    lsi(circuit, 'rule-r11-1').parameters!.key = 'KeyU';
    circuit.lsis = circuit.lsis!.filter((l) => l.id !== 'rule-r10');
    circuit.lsis.push({ id: 'kick', type: 'push', parameters: { character: 'ball', link: '', duration: 0.3 }, values: { force: [0, 0, 9] } }, { id: 'k', type: 'keyboard', parameters: { key: 'KeyB' } });
    circuit.wires!.push({ from: 'k.pressed', to: 'kick.when' });
    const commands = keep_wired(wired_rules(circuit, doc))!;
    expect(commands.map((c) => c.type)).toEqual(['rule.remove', 'rule.set', 'rule.add', 'circuit.set']);
    const kept = commands.reduce((d, c) => apply_command(d, c), { ...doc, circuit } as ScenarioDocument);
    expect(kept.circuit).toBeFalsy();
    expect(kept.rules!.find((r) => r.id === 'r11')!.if[0]!.key).toBe('KeyU');
    expect(kept.rules!.some((r) => r.id === 'r10')).toBe(false);
  });

  it('is not offered if nothing changed, or if a part has no form of a rule', () => {
    expect(keep_wired(wired_rules(sample.circuit, doc))).toBeNull();
    const circuit = copy();
    circuit.wires = circuit.wires!.filter((w) => w.to !== 'rule-r5.when');
    expect(keep_wired(wired_rules(circuit, doc))).toBeNull();
  });
});

import { describe, expect, it, vi } from 'vitest';
import { CommandRegistry } from '../src/core/commands';
import { format_factor, format_field, format_number, format_ruler, format_time, parse_number, format_label } from '../src/core/format';
import { grade, measures, shown_value } from '../src/core/judge';
import { is_typing, key_of, pointer_action, show_key } from '../src/core/keymap';
import { describe_entry, format_mass, tags_of } from '../src/core/library/words';
import type { LibraryEntry } from '../src/core/protocol';

describe('formatting', () => {
  it('formats times', () => {
    expect([0, 3.42, 59.999, 61.5, -0.5].map(format_time)).toEqual(['00:00.00', '00:03.42', '01:00.00', '01:01.50', '-00:00.50']);
  });
  it('formats numbers without trailing zeros', () => {
    expect([1.2, 4.37, -0.001, 100, NaN].map((v) => format_number(v))).toEqual(['1.2', '4.37', '0', '100', '–']);
    expect([1.2, 0.0001, -0.00012345, 0, 1e-9].map((v) => format_field(v, 3))).toEqual(['1.2', '0.0001', '-0.000123', '0', '1e-9']);
  });
  it('puts the side first in labels', () => {
    expect(['forearm left', 'pelvis', 'toes_right', 'Left hand', ''].map(format_label)).toEqual(['Left forearm', 'Pelvis', 'Right toes', 'Left hand', '']);
  });
  it('formats ruler labels and factors', () => {
    expect([format_ruler(0, 1), format_ruler(3, 1), format_ruler(0.5, 0.5), format_ruler(90, 30)]).toEqual(['0', '3 s', '0.5 s', '1:30']);
    expect([38.2, 0.42, 0].map(format_factor)).toEqual(['38×', '0.4×', '–']);
  });
});

describe('parse_number', () => {
  it.each([
    ['1.5', 1.5], ['1,5', 1.5], [' -2 ', -2], ['3 s', 3], ['15 % of weight', 15], ['1+0.25', 1.25], ['90/2', 45], ['2*3-1', 5], ['-1--2', 1], ['1e-3', 0.001], ['.5', 0.5], ['9.81 m/s²', 9.81],
    ['', null], ['abc', null], ['1/0', null], ['1..2', null], ['alert(1)', null], ['--', null],
  ])('%s', (text, value) => {
    if (value === null) expect(parse_number(text)).toBeNull();
    else expect(parse_number(text)).toBeCloseTo(value, 12);
  });
});

const key = (k: string, more: object = {}) => ({ key: k, ctrlKey: false, metaKey: false, shiftKey: false, altKey: false, ...more });

describe('keys', () => {
  it('have one name for each combination', () => {
    expect(key_of(key('z', { ctrlKey: true }))).toBe('Ctrl+Z');
    expect(key_of(key('Z', { ctrlKey: true, shiftKey: true }))).toBe('Ctrl+Shift+Z');
    expect(key_of(key('s', { metaKey: true }))).toBe('Ctrl+S');
    expect(key_of(key('?', { shiftKey: true }))).toBe('?');
    expect(key_of(key(' '))).toBe('Space');
    expect(key_of(key('ArrowLeft', { shiftKey: true }))).toBe('Shift+ArrowLeft');
    expect(show_key('Ctrl+ArrowLeft')).toBe('Ctrl ←');
  });
  it('typed into a field are not shortcuts', () => {
    expect(is_typing({ tagName: 'input', type: 'text' })).toBe(true);
    expect(is_typing({ tagName: 'INPUT', type: 'range' })).toBe(false);
    expect(is_typing({ tagName: 'BUTTON' })).toBe(false);
    expect(is_typing(null)).toBe(false);
  });
  it('map pointer buttons in both keymaps', () => {
    const plain = { altKey: false, shiftKey: false, ctrlKey: false };
    expect(pointer_action('industry', 0, plain)).toBe('select_or_orbit');
    expect(pointer_action('industry', 0, { ...plain, altKey: true })).toBe('orbit');
    expect(pointer_action('industry', 1, plain)).toBe('pan');
    expect(pointer_action('industry', 2, { ...plain, altKey: true })).toBe('zoom');
    expect(pointer_action('blender', 1, plain)).toBe('orbit');
    expect(pointer_action('blender', 1, { ...plain, shiftKey: true })).toBe('pan');
    expect(pointer_action('blender', 1, { ...plain, ctrlKey: true })).toBe('zoom');
    expect(pointer_action('blender', 0, plain)).toBe('select_or_orbit');
  });
});

describe('CommandRegistry', () => {
  const make = () => {
    const registry = new CommandRegistry();
    const run = vi.fn();
    registry.add(
      { id: 'a', label: 'Split clip', group: 'Edit', industry: ['S'], blender: ['K'], run },
      { id: 'b', label: 'Frame all', group: 'View', keys: ['A'], enabled: () => false, run },
      { id: 'c', label: 'All commands', group: 'Page', keys: ['Ctrl+K', 'Ctrl+P'], run },
    );
    return { registry, run };
  };
  it('finds commands by any of their words, best match first', () => {
    const { registry } = make();
    expect(registry.search('all').map((c) => c.id)).toEqual(['c', 'b']);
    expect(registry.search('clip edit').map((c) => c.id)).toEqual(['a']);
    expect(registry.search('no such command')).toEqual([]);
    expect(registry.search(' ').length).toBe(3);
  });
  it('finds commands by the keys of the keymap', () => {
    const { registry } = make();
    expect(registry.by_key('S', 'industry')?.id).toBe('a');
    expect(registry.by_key('S', 'blender')).toBeUndefined();
    expect(registry.by_key('Ctrl+P', 'blender')?.id).toBe('c');
  });
  it('does not run disabled commands, and rejects a second command of the same id', () => {
    const { registry, run } = make();
    expect(registry.run('b')).toBe(false);
    expect(registry.run('a')).toBe(true);
    expect(run).toHaveBeenCalledOnce();
    expect(() => registry.add({ id: 'a', label: '', group: '', run })).toThrow(/twice/);
  });
});

describe('library entries', () => {
  const entries: LibraryEntry[] = [
    { id: 'm', kind: 'mechanism', name: 'Human 1.75 m', dofs: 62, mass: 70.04, height: 1.75, tags: ['person'] },
    { id: 'n', kind: 'motion', name: 'walk, relaxed', duration: 4.37, rate: 120, cyclic: true, tags: 'gait made' },
  ];
  it('are described in one line', () => {
    expect([0.0008, 0.032, 0.9996, 4.46, 70.2].map(format_mass)).toEqual(['0.8 g', '32 g', '1 kg', '4.5 kg', '70 kg']);
    expect(entries.map(describe_entry)).toEqual(['1.75 m · 70 kg · 62 DOF', '4.37 s · 120 Hz · cyclic']);
    expect(describe_entry({ id: 'x', kind: 'motion', name: 'bare' })).toBe('');
  });
  it('have tags as a list or as text', () => {
    expect(tags_of(entries[1]!)).toEqual(['gait', 'made']);
  });
});

describe('measures', () => {
  it('are graded in the displayed units', () => {
    const assist = measures[0]!;
    const summary = { id: 'a', assist_rms_bw: 0.041, foot_skate_cm: 0.6, tracking_rms_deg: 1.9, penetration_mm: 2, fell: false };
    expect(shown_value(assist, summary)).toBeCloseTo(4.1);
    expect([4.1, 9, 16, NaN].map((v) => grade(assist, v))).toEqual(['good', 'fair', 'bad', 'none']);
    expect(shown_value(assist, undefined)).toBeNaN();
  });
});

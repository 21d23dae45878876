import { describe, expect, it } from 'vitest';
import { CommandRegistry, type AppCommand } from '../src/core/commands';
import { conflicts, count_edits, give_key, no_key_edits, parse_key_file, read_key_edits, reserved, set_keys, write_key_edits } from '../src/core/key_edits';
import { read_choices } from '../src/core/state';

const nothing = (): void => undefined;
const command = (id: string, keys: Partial<AppCommand>): AppCommand => ({ id, label: id, group: 'Test', run: nothing, ...keys });
const play = command('play', { keys: ['Space'] });
const key = command('key', { industry: ['S'], blender: ['I'] });
const tool = command('tool', { keys: ['E'] });
const turn = command('turn', { keys: ['E'], enabled: () => false });
const all = [play, key, tool, turn];

describe('changed keys', () => {
  it('replace those of one keymap, and equal keys are not stored', () => {
    const edits = set_keys(no_key_edits, 'industry', key, ['Shift+S']);
    expect(edits).toEqual({ industry: { key: ['Shift+S'] }, blender: {} });
    expect(set_keys(edits, 'industry', key, ['S'])).toEqual(no_key_edits);
    const registry = new CommandRegistry();
    registry.add(...all);
    registry.edits = edits;
    expect(registry.keys_of(key, 'industry')).toEqual(['Shift+S']);
    expect(registry.keys_of(key, 'blender')).toEqual(['I']);
    expect(registry.by_key('S', 'industry')).toBeUndefined();
    expect(registry.by_key('Shift+S', 'industry')).toBe(key);
    registry.edits = set_keys(edits, 'industry', play, []);
    expect(registry.by_key('Space', 'industry')).toBeUndefined();
  });

  it('name conflicts, except those that the keymap intends', () => {
    expect(conflicts(all, key, 'Space', 'industry', no_key_edits)).toEqual([play]);
    expect(conflicts(all, tool, 'E', 'industry', no_key_edits)).toEqual([]);
    expect(conflicts(all, play, 'E', 'industry', no_key_edits)).toEqual([tool, turn]);
    expect(conflicts(all, play, 'Space', 'industry', no_key_edits)).toEqual([]);
  });

  it('are taken over from other commands', () => {
    const edits = give_key(no_key_edits, all, key, 'Space', 'industry');
    expect(edits.industry).toEqual({ play: [], key: ['S', 'Space'] });
    const back = give_key(edits, all, play, 'Space', 'industry');
    expect(back).toEqual(no_key_edits);
    expect(give_key(edits, all, key, 'Space', 'industry')).toEqual(edits); // twice is once
  });

  it('are not those of the browser', () => {
    for (const k of ['Shift', 'Ctrl+Control', 'Escape', 'Tab', 'Ctrl+W', 'Ctrl+Shift+T', 'F5']) expect(reserved(k)).toMatch(/\. /);
    for (const k of ['Shift+S', 'Ctrl+Shift+S', 'F2', 'W', 'Ctrl+ArrowUp']) expect(reserved(k)).toBeNull();
  });

  it('are written to files and read from them', () => {
    const edits = give_key(no_key_edits, all, key, 'Space', 'blender');
    const known = (id: string): boolean => all.some((c) => c.id === id);
    expect(parse_key_file(write_key_edits(edits), known)).toEqual({ edits, problems: [] });
    expect(() => parse_key_file('{', known)).toThrow('not JSON');
    expect(() => parse_key_file('{}', known)).toThrow('not a list of keys');
    expect(() => parse_key_file('{"format": "ugoki keys", "version": 2}', known)).toThrow('version 2');
    const odd = parse_key_file('{"format": "ugoki keys", "version": 1, "industry": {"no": ["A"], "play": "A", "key": ["Escape"], "tool": ["Q"]}, "blender": 3}', known);
    expect(odd.edits).toEqual({ industry: { tool: ['Q'] }, blender: {} });
    expect(odd.problems.map((p) => p.split(':')[0])).toEqual(['industry/no', 'industry/play', 'industry/key', 'blender']);
  });

  it('are kept with the choices of the user', () => {
    expect(read_choices({ keymap: 'blender', keys: { blender: { play: ['F9'] } } })).toMatchObject({ keymap: 'blender', key_edits: { industry: {}, blender: { play: ['F9'] } } });
    expect(read_choices({ keys: 'x' }).key_edits).toEqual(no_key_edits);
    expect(count_edits(read_key_edits({ industry: { a: ['A'], b: [] } }).edits, 'industry')).toBe(2);
  });
});

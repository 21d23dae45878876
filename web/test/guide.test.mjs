import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { expect, test } from 'vitest';
import { gallery } from '../src/core/gallery';

const folder = new URL('../../docs/guide/', import.meta.url);
const chapters = ['creators.md', 'specialists.md'].map((name) => readFileSync(new URL(name, folder), 'utf8'));

test('the guide explains each content of the gallery', () => {
  const text = chapters[0].replaceAll('’', "'");
  for (const { title } of gallery) expect(text).toContain(`| **${title.replaceAll('’', "'")}** |`);
});

test('the guide shows each of its pictures', () => {
  const shown = new Set(chapters.flatMap((text) => [...text.matchAll(/\]\(images\/([\w-]+\.webp)\)/g)].map((found) => found[1])));
  for (const name of shown) expect(existsSync(new URL(`images/${name}`, folder)), name).toBe(true);
  for (const name of readdirSync(new URL('images', folder))) expect(shown, `${name} is in no chapter`).toContain(name);
});

import { expect, it } from 'vitest';
import { card_place, tour_steps } from '../src/core/tour';

it('the card of the tour is beside its part and inside of the window', () => {
  const window = { width: 1280, height: 720 };
  const card = { width: 340, height: 150 };
  for (const part of [
    { left: 0, top: 48, width: 240, height: 400 }, // library
    { left: 0, top: 450, width: 1280, height: 270 }, // timeline
    { left: 1020, top: 48, width: 260, height: 400 }, // inspector
    { left: 1250, top: 8, width: 24, height: 24 }, // a button in a corner
  ]) {
    const { left, top } = card_place(part, card, window);
    expect(left).toBeGreaterThanOrEqual(12);
    expect(top).toBeGreaterThanOrEqual(12);
    expect(left + card.width).toBeLessThanOrEqual(window.width - 12);
    expect(top + card.height).toBeLessThanOrEqual(window.height - 12);
    const apart = left + card.width <= part.left || left >= part.left + part.width || top + card.height <= part.top || top >= part.top + part.height;
    expect(apart, JSON.stringify({ part, left, top })).toBe(true);
  }
  expect(tour_steps.every((s) => s.title.length < 40 && s.text.length < 200)).toBe(true);
});

// Starts the system's Chromium for journeys and screenshots, with WebGL rendered in software; waits for states of the page.
import { existsSync } from 'node:fs';
import { chromium } from 'playwright-core';

/** The program to start: the headless shell takes an eighth less processor time for a journey than Chromium. */
export const browser_program = process.env.UGOKI_CHROMIUM ?? ['/usr/bin/chromium-headless-shell', '/usr/bin/chromium'].find(existsSync);

/**
 * @param renderer renderer of WebGL: 'swiftshader', or 'gl-egl' (Mesa), which `ugoki export` uses. Mesa takes a quarter less processor time
 * for most journeys, but with it the page of a textured skin sometimes stands still for a minute.
 */
export const launch = (renderer = 'swiftshader') =>
  chromium.launch({
    executablePath: browser_program,
    args: [
      '--headless', '--no-sandbox', '--use-gl=angle', `--use-angle=${renderer}`, '--enable-unsafe-swiftshader', ...(renderer === 'swiftshader' ? [] : ['--ignore-gpu-blocklist']), '--disable-quic', '--no-first-run',
      // rasterize the page on the CPU; only WebGL uses SwiftShader, with which rasterizing the page would take ten times as long
      '--disable-gpu-rasterization', '--disable-accelerated-2d-canvas',
      '--disable-background-networking', '--disable-component-update', '--disable-sync',
    ],
  });

/** Waits until the page is connected and has drawn a received frame. */
export async function ready(page, timeout = 60000) {
  await page.waitForFunction(() => window.ugoki?.connected && window.ugoki.pictures > 1 && window.ugoki.frames_received > 0, undefined, { timeout });
}

/** Calls `ask` until its result is truthy, and returns this result. Throws an error after `timeout` ms. */
export async function until(page, ask, description, timeout = 60000) {
  const end = Date.now() + timeout;
  for (;;) {
    const value = await ask();
    if (value) return value;
    if (Date.now() > end) throw new Error(`waited ${timeout / 1000} s in vain for: ${description}`);
    await page.waitForTimeout(60);
  }
}
export const document_of = (page) => page.evaluate(() => window.ugoki.document());
export const text_of = async (page) => JSON.stringify(await document_of(page));
/** Takes the focus from fields, so that keys reach the page. */
export const blur = (page) => page.evaluate('document.activeElement?.blur?.()');

/** Undoes or redoes one command by a key, and waits until it is done. */
export async function step_history(page, key) {
  const { revision } = await page.evaluate('window.ugoki.undo()');
  await page.keyboard.press(key);
  await until(page, async () => (await page.evaluate('window.ugoki.undo()')).revision !== revision, `the command after ${key}`, 20000);
}

/** Undoes commands while `ask` is truthy, at most 60. */
export async function undo_while(page, ask) {
  for (let count = 0; await ask(); count++) {
    if (!(await page.evaluate('window.ugoki.undo()')).can_undo || count >= 60) throw new Error('undo does not lead to the former state');
    await step_history(page, 'Control+z');
  }
}

/** Waits until the page has painted its newest state and no transition runs. */
export const painted = (page) =>
  page.evaluate(async () => {
    const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
    await frame();
    await frame();
    const ends = document.getAnimations().filter((a) => a.effect?.getComputedTiming().endTime !== Infinity).map((a) => a.finished.catch(() => undefined));
    await Promise.all(ends);
    await frame();
  });

/** Switches between the dark and the light theme. */
export async function toggle_theme(page) {
  await page.getByRole('button', { name: 'Switch between dark and light theme' }).click();
  await painted(page);
}

/** Undoes commands until the text of the document is `wanted`. @return the number of undone commands */
export async function undo_to(page, wanted) {
  await blur(page);
  let count = 0;
  await undo_while(page, async () => (await text_of(page)) !== wanted && ++count);
  return count;
}
/** Switches to 'Edit' or 'Simulate'. */
export async function set_mode(page, name) {
  await page.getByRole('radio', { name }).click();
  await until(page, () => page.evaluate((mode) => window.ugoki.transport().mode === mode, name.toLowerCase()), name);
}

/** Waits until the camera of the viewport has reached its place, so that positions on the screen stay valid. */
export const camera_rests = (page) => until(page, () => page.evaluate('!(window.ugoki.camera()?.moving ?? true)'), 'a camera at rest');

/** Waits until the view is at rest and painted. For pictures that people look at, also until it is drawn at full resolution. */
export async function rested(page) {
  await camera_rests(page);
  await painted(page);
  if (process.env.UGOKI_PICTURES === '1') await page.waitForTimeout(900);
}

/** Waits until three answers of `ask`, 100 ms apart, are equal, and returns the answer. */
export async function steady(page, ask, description) {
  let last, equal = 0;
  await until(page, async () => {
    const now = JSON.stringify(await ask());
    equal = now === last ? equal + 1 : 0;
    last = now;
    await page.waitForTimeout(40);
    return equal >= 2;
  }, description);
  return JSON.parse(last);
}

// Starts the system's Chromium for journeys and screenshots, with WebGL rendered in software; waits for states of the page.
import { chromium } from 'playwright-core';

/** @param renderer renderer of WebGL: 'swiftshader', or 'gl-egl' (Mesa), which `ugoki export` uses */
export const launch = (renderer = 'swiftshader') =>
  chromium.launch({
    executablePath: process.env.UGOKI_CHROMIUM ?? '/usr/bin/chromium',
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

/** Undoes commands until the text of the document is `wanted`. */
export async function undo_to(page, wanted) {
  await blur(page);
  for (let i = 0; (await text_of(page)) !== wanted; i++) {
    const { can_undo, revision } = await page.evaluate('window.ugoki.undo()');
    if (!can_undo || i >= 60) throw new Error('undo does not lead to the former document');
    await page.keyboard.press('Control+z');
    await until(page, async () => (await page.evaluate('window.ugoki.undo()')).revision !== revision, 'an undone command', 20000);
  }
}
/** Switches to 'Edit' or 'Simulate'. */
export async function set_mode(page, name) {
  await page.getByRole('radio', { name }).click();
  await until(page, () => page.evaluate((mode) => window.ugoki.transport().mode === mode, name.toLowerCase()), name);
}

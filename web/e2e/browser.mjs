// Chromium for journeys and pictures: the one of the system, drawing WebGL in software.
import { chromium } from 'playwright-core';

export const launch = () =>
  chromium.launch({
    executablePath: process.env.UGOKI_CHROMIUM ?? '/usr/bin/chromium',
    args: [
      '--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
      // the page is drawn by the processor, WebGL alone by SwiftShader: all by SwiftShader is ten times slower
      '--disable-gpu-rasterization', '--disable-accelerated-2d-canvas',
      '--disable-background-networking', '--disable-component-update', '--disable-sync',
    ],
  });

/** Waits until figures are drawn. */
export async function ready(page, timeout = 60000) {
  await page.waitForFunction(() => window.ugoki?.connected && window.ugoki.pictures > 1 && window.ugoki.frames_received > 0, undefined, { timeout });
}

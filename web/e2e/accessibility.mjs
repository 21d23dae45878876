// Journeys (end-to-end tests) for accessibility and layout: axe-core in both themes, keyboard focus, windows from 960 x 600 px to 4K.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';
import { painted, step_history, toggle_theme, until } from './browser.mjs';
import { leg_swing_bvh } from './library.mjs';
import { mock } from './service.mjs';
import { crowded, resize, windows } from './windows.mjs';

const skip = mock && 'the mock service has no library and no circuit';
const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const axe_source = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/** Violations that axe-core finds in the page as it is shown, one line for each element. */
export async function violations(page) {
  if (!(await page.evaluate("typeof axe === 'object'"))) await page.evaluate(axe_source);
  return page.evaluate(async () => {
    const { violations: found } = await window.axe.run(document, { resultTypes: ['violations'] });
    return found.flatMap((v) => v.nodes.map((n) => `${v.id}: ${n.target.join(' ')}: ${[...n.any, ...n.all, ...n.none].map((c) => c.message).join('; ')}`));
  });
}

const escape = (page) => page.keyboard.press('Escape');

/** Views of the page: name, function that opens the view, and, if needed, function that leaves it. */
export const views = [
  ['the scenario', (page) => page.locator('.scenario').click({ position: { x: 400, y: 6 } })],
  ['a selected clip', (page) => page.locator('.clip').first().click()],
  ['the menu of a clip', (page) => page.locator('.clip').first().click({ button: 'right' }), escape],
  ['an operation on a motion', async (page) => {
    await page.locator('.clip').first().click();
    await page.getByRole('button', { name: 'Follow a path…' }).or(page.locator('.motion-operations button[aria-label$="…"]')).first().click();
    await page.getByRole('dialog').waitFor();
  }, escape],
  ['a selected character', (page) => page.locator('.track-name').first().click()],
  ['the look', (page) => page.getByRole('tab', { name: 'Look' }).click(), (page) => page.getByRole('tab', { name: 'Inspector' }).click()],
  ['a selected event', (page) => page.locator('.pill').first().click()],
  ['a library entry', (page) => page.locator('#library-list [role=option]').first().click()],
  ['the menu of an entry', (page) => page.locator('#library-list [role=option]').first().click({ button: 'right' }), escape],
  ['the library as tiles', (page) => page.getByRole('button', { name: 'Show as tiles' }).click(), (page) => page.getByRole('button', { name: 'Show as a list' }).click()],
  ['the trash', (page) => page.getByTitle('Show deleted entries').click(), (page) => page.getByTitle('Show the library').click()],
  ['a search without a result', (page) => page.getByRole('searchbox', { name: 'Search the library' }).fill('xyzzy'), (page) => page.getByRole('searchbox', { name: 'Search the library' }).fill('')],
  ['the command palette', (page) => page.keyboard.press('Control+k'), escape],
  ['the keys', (page) => page.keyboard.press('F1'), escape],
  ['the change of keys', async (page) => {
    await page.keyboard.press('F1');
    await page.getByRole('button', { name: 'Change keys…' }).click();
    await page.locator('.key-editor-row').first().waitFor();
  }, escape],
  ['the tour', async (page) => {
    await page.keyboard.press('F1');
    await page.getByRole('button', { name: 'Take the tour' }).click();
    await page.locator('.tour').waitFor();
  }, escape],
  ['Save as', (page) => page.keyboard.press('Control+Shift+s'), escape],
  ['the exports', (page) => page.getByRole('button', { name: 'Export', exact: true }).click(), escape],
  ['the kinds of props', (page) => page.getByRole('button', { name: '+ Prop' }).click(), escape],
  ['the plots', (page) => page.getByRole('tab', { name: 'Plots' }).click(), (page) => page.getByRole('tab', { name: 'Scenario' }).click()],
];

const mode = async (page, name) => {
  await page.getByRole('radio', { name }).click();
  for (let i = 0; i < 600 && (await page.evaluate('window.ugoki.transport().mode')) !== name.toLowerCase(); i++) await page.waitForTimeout(50);
};
const tab = (page, name) => page.getByRole('tab', { name }).click();
const pause = async (page) => {
  if (await page.evaluate('window.ugoki.transport().playing')) await page.getByRole('button', { name: 'Pause' }).click();
};

/** Views that need a circuit, a simulation or a file. */
export const deep_views = [
  ['the circuit', async (page) => {
    await tab(page, 'Circuit');
    await page.locator('.circuit[role=application]').waitFor();
  }],
  ['all LSIs selected', async (page) => {
    await page.locator('.circuit[role=application]').focus();
    await page.keyboard.press('Control+a');
  }, escape],
  ['the search of LSIs', async (page) => {
    await page.keyboard.press('Control+k');
    await page.keyboard.type('add an lsi');
    await page.keyboard.press('Enter');
    await page.locator('.candidate-name').first().waitFor();
  }, async (page) => {
    await escape(page);
    await tab(page, 'Scenario');
  }],
  ['no rules', async (page) => {
    await mode(page, 'Edit');
    await tab(page, 'Rules');
  }],
  ['a rule', async (page) => {
    await page.getByRole('button', { name: 'When something touches, play…' }).click();
    await page.locator('.rule').waitFor();
  }, async (page) => {
    await page.getByRole('button', { name: 'Remove rule 1' }).click();
    await page.locator('.rule').waitFor({ state: 'detached' });
    for (let i = 0; i < 2; i++) await step_history(page, 'Control+z');
    await tab(page, 'Scenario');
  }],
  ['rules with a variable', async (page) => {
    await tab(page, 'Rules');
    await page.getByRole('button', { name: '+ Rule' }).click();
    await page.getByRole('menuitem', { name: 'When something touches, count…' }).click();
    await page.locator('.rule').waitFor();
    await page.locator('.variable').click();
  }, async (page) => {
    await page.locator('.rules-head').click();
    await page.keyboard.press('Control+z');
    await page.locator('.rule').waitFor({ state: 'detached' });
    await tab(page, 'Scenario');
  }],
  ['posing', async (page) => {
    await page.locator('.track-name').first().click();
    await page.evaluate('document.activeElement?.blur?.()');
    await page.keyboard.press('e');
    await page.locator('.pose-handles button').first().waitFor();
    await page.waitForFunction(() => window.ugoki.posing()?.ready);
  }],
  ['the curves', async (page) => {
    await page.keyboard.press('Shift+S');
    await tab(page, 'Curves');
    await page.locator('.curve-plot canvas').waitFor();
    await page.locator('.curve-row').first().waitFor();
  }, async (page) => {
    await step_history(page, 'Control+z');
    await page.keyboard.press('e');
    await tab(page, 'Scenario');
  }],
  ['no stored poses', async (page) => {
    await page.locator('.track-name').first().click();
    await tab(page, 'Poses');
    await page.locator('.poses-empty').first().waitFor();
  }],
  ['a stored pose', async (page) => {
    await page.getByRole('button', { name: 'Store pose', exact: true }).click();
    await page.getByRole('textbox', { name: 'Name of the pose' }).press('Enter');
    await page.getByRole('option', { name: 'Pose 1' }).waitFor();
  }, async (page) => {
    await page.evaluate('document.activeElement?.blur?.()');
    await page.keyboard.press('Control+z');
    await page.locator('.pose-card').waitFor({ state: 'detached' });
    await page.keyboard.press('e');
    await tab(page, 'Library');
  }],
  ['naturalness without a simulation', async (page) => {
    await mode(page, 'Edit');
    await tab(page, 'Naturalness');
  }],
  ['naturalness', async (page) => {
    await mode(page, 'Simulate');
    await page.locator('.transport').getByRole('button', { name: 'Play' }).click();
    for (let i = 0; i < 1200 && (await page.evaluate('window.ugoki.measures().frames')) < 40; i++) await page.waitForTimeout(50);
    await pause(page);
    await page.locator('.nat-row').first().waitFor();
  }],
  ['the simulation', async (page) => {
    await tab(page, 'Scenario');
    await page.locator('.track-name').first().click();
  }],
  ['the log', (page) => tab(page, 'Log'), (page) => tab(page, 'Scenario')],
  ['the import', async (page) => {
    await mode(page, 'Edit');
    await page.locator('.library input[type=file]').setInputFiles([{ name: 'waver.bvh', mimeType: 'application/octet-stream', buffer: leg_swing_bvh() }]);
    await page.getByRole('dialog', { name: 'Import' }).waitFor({ timeout: 60000 });
    for (let i = 0; i < 1200 && !(await page.evaluate("window.ugoki.imports().every((f) => f.status === 'ready')")); i++) await page.waitForTimeout(50);
  }, async (page) => {
    await escape(page);
    await page.getByRole('dialog', { name: 'Import' }).waitFor({ state: 'detached', timeout: 60000 });
  }],
  ['several selected clips and events', async (page) => {
    await page.locator('.ruler').focus();
    await page.keyboard.press('Control+a');
  }],
  ['the menu of the project', (page) => page.locator('button.project').click(), escape],
  ['the gallery', async (page) => {
    await page.locator('button.project').click();
    await page.getByRole('menuitem', { name: 'New project…' }).click();
  }, escape],
  ['Open project', (page) => page.keyboard.press('Control+o'), escape],
];

/** Opens each view, gives the window each size, and fails with the list of all controls that are covered or cut. @param whole also with axe-core, and pictures */
async function check_windows(page, list, sizes, whole = false) {
  const bad = [];
  const theme = await page.evaluate(() => document.documentElement.dataset.theme);
  for (const [name, open, leave] of list) {
    try {
      await open(page);
    } catch (error) {
      throw new Error(`${name} (${theme}) does not open: ${error.message}; found before: ${bad.join('\n')}`, { cause: error });
    }
    for (const [width, height] of sizes) {
      await resize(page, [width, height]);
      const found = await crowded(page);
      if (whole && (width < 900 || width === 1440)) found.push(...(await violations(page)));
      for (const line of new Set(found)) bad.push(`${name}, ${width} x ${height} (${theme}): ${line}`);
      if (sizes.length > 1 || process.env.UGOKI_PICTURES === '1') await page.screenshot({ path: `${pictures}view-${name.replaceAll(' ', '-')}-${width}-${theme}.png` });
    }
    await resize(page, [1440, 900]);
    await leave?.(page);
  }
  assert.ok(bad.length === 0, `found:\n${bad.join('\n')}`);
}

export const accessibility_journeys = [
  {
    name: 'access: axe-core finds no violation in scenario, library, inspector and dialogs, in the light theme',
    async run({ page }) {
      const found = [];
      await toggle_theme(page);
      assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'light');
      for (const [name, open, leave] of views) {
        await open(page);
        await painted(page);
        for (const line of await violations(page)) found.push(`${name}: ${line}`);
        await leave?.(page);
      }
      await toggle_theme(page);
      assert.deepEqual([...new Set(found)], []);
    },
  },
  {
    name: 'access: a closed menu returns the focus, and arrow keys select tabs',
    async run({ page }) {
      const focus = () => page.evaluate(() => document.activeElement?.dataset.clip ?? document.activeElement?.textContent ?? '');
      const clip = page.locator('.clip').first();
      await clip.click({ button: 'right' });
      await clip.focus();
      await page.keyboard.press('Shift+F10');
      await page.getByRole('menu').waitFor();
      await page.keyboard.press('Escape');
      await page.getByRole('menu').waitFor({ state: 'detached' });
      assert.equal(await focus(), await clip.getAttribute('data-clip'));
      await page.getByRole('tab', { name: 'Scenario' }).focus();
      await page.keyboard.press('ArrowRight');
      assert.equal(await focus(), 'Curves');
      assert.equal(await page.getByRole('tab', { name: 'Curves' }).getAttribute('aria-selected'), 'true');
      assert.equal(await page.getByRole('tab', { name: 'Scenario' }).getAttribute('aria-selected'), 'false');
      await page.keyboard.press('Home');
      assert.equal(await focus(), 'Scenario');
      assert.ok(await page.locator('.scenario').isVisible());
    },
  },
  {
    name: 'access: in windows from 853 x 480 to 4K nothing is covered or cut, and the viewport takes the change of size',
    async run({ page }) {
      const bad = [];
      const widths = () => page.evaluate(() => ['.library', '.inspector'].map((s) => Math.round(document.querySelector(s).getBoundingClientRect().width)));
      await page.locator('.clip').first().click();
      const before = await widths();
      for (const [width, height] of windows) {
        await resize(page, [width, height]);
        for (const line of await crowded(page)) bad.push(`${width} x ${height}: ${line}`);
        if (width >= 960 && width < 2400) {
          assert.deepEqual(await widths(), before, `${width} x ${height}: the side panels keep their width`);
          await page.screenshot({ path: `${pictures}window-${width}.png` });
        }
      }
      await page.setViewportSize({ width: 480, height: 400 }); // too small for the panels
      await until(page, async () => (await widths()).every((w, i) => w < before[i]), 'smaller panels', 20000);
      await page.setViewportSize({ width: 1440, height: 900 });
      await until(page, async () => String(await widths()) === String(before), 'panels that have their width again', 20000);
      assert.deepEqual(bad, []);
    },
  },
  {
    name: 'access: no control of any view is covered or cut at 853 x 480, and axe-core finds no violation',
    run: ({ page }) => check_windows(page, [...views, ...deep_views], windows.slice(0, 1), true),
  },
  {
    name: 'access: every view in every size of the window, in both themes, with axe-core',
    slow: true,
    async run({ page }) {
      for (let round = 0; round < 2; round++) {
        await check_windows(page, [...views, ...deep_views], windows, true);
        await toggle_theme(page);
      }
    },
  },
].map((journey) => ({ ...journey, skip }));

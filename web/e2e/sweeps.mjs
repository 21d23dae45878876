// Journey for the results of sweeps: the dialog that plots a table of `ugoki bake`.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { violations } from './accessibility.mjs';
import { until } from './browser.mjs';
import { mock } from './service.mjs';

const pictures = fileURLToPath(new URL('./out/', import.meta.url));
const choice = (page, name) => dialog(page).getByRole('combobox', { name: new RegExp(`^${name}`) });
const dialog = (page) => page.getByRole('dialog', { name: 'Results of sweeps' });

async function open(page) {
  await page.keyboard.press('Control+k');
  await page.getByLabel('Search commands').fill('results of a sweep');
  await page.keyboard.press('Enter');
  await dialog(page).waitFor();
}
async function saved(page, name) {
  const [download] = await Promise.all([page.waitForEvent('download'), dialog(page).getByRole('button', { name, exact: true }).click()]);
  return { name: download.suggestedFilename(), text: readFileSync(await download.path(), 'utf8') };
}

export const sweep_journeys = [
  {
    name: 'sweep: the results of a sweep are plotted over the varied quantity, and saved as SVG and CSV',
    skip: mock && 'the mock service has no tables of results',
    run: async ({ page, service }) => {
      await open(page);
      await dialog(page).getByText('There is no table of results').waitFor();
      await page.keyboard.press('Escape');
      const made = service.run(['bake', 'sample.ugoki', '--vary', 'push=0:300:3', '--vary', 'push-angle=0,90', '--vary', 'push-time=0.05', '--duration', '0.3', '--table', 'push.db', '--csv', 'push.csv']);
      assert.equal(made.status, 0, made.stderr);
      await open(page);
      const canvas = dialog(page).getByRole('img');
      await canvas.waitFor();
      assert.equal(await choice(page, 'Table').inputValue(), 'table=push.db');
      await choice(page, 'Measure').selectOption('tracking_rms_deg');
      await choice(page, 'Over').selectOption('push');
      await choice(page, 'Series').selectOption('push-angle');
      await until(page, async () => (await canvas.getAttribute('aria-label')).startsWith('tracking_rms_deg over push: 6 runs'), 'the plot');
      assert.deepEqual(await dialog(page).getByRole('list', { name: 'push-angle' }).getByRole('listitem').allTextContents(), ['push-angle', '0', '90']);
      // the pointer on a dot shows its run: the runs with a push of 0 N are at the left end of the axis
      const box = await canvas.boundingBox();
      let shown = '';
      for (let y = 10; y < box.height && !shown; y += 6) {
        await page.mouse.move(box.x + 72, box.y + y);
        shown = await dialog(page).getByRole('status').textContent({ timeout: 50 }).catch(() => '');
      }
      assert.match(shown, /^Run \d+push 0push-angle (0|90)/);
      await page.screenshot({ path: `${pictures}sweep.png` });
      const svg = await saved(page, 'Save SVG');
      assert.equal(service.run(['bake', 'plot', 'push.db', '--x', 'push', '--y', 'tracking_rms_deg', '--by', 'push-angle', '--out', 'push.svg']).status, 0);
      assert.equal(svg.text, readFileSync(`${service.folder}/push.svg`, 'utf8'));
      assert.equal(svg.name, 'push tracking_rms_deg.svg');
      assert.equal((await saved(page, 'Save CSV')).text, readFileSync(`${service.folder}/push.csv`, 'utf8'));
      assert.deepEqual(await violations(page), []);
      await dialog(page).getByLabel('Other file').fill('/nowhere/push.db');
      await page.keyboard.press('Enter');
      await dialog(page).getByRole('alert').getByText('There is no such file.').waitFor();
      await page.keyboard.press('Escape');
      await dialog(page).waitFor({ state: 'detached' });
    },
  },
];

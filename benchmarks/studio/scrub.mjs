// Jumps of the playhead in a scenario of 10 minutes: time until the frame is in the page, and the processor time that a jump needs, which is also
// valid on a busy machine.
import { load_of, walkers, with_studio } from './measured_studio.mjs';

const duration = 600; // of the scenario, s
const jumps = 300; // so that the 99 % value is not the slowest jump
const settled_ms = 4000; // the page draws pictures of the library and compiles its scripts after its start

export const quantile = (values, q) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(q * values.length))] ?? NaN;

/** Processor times (ms) of the tasks of the page's main thread while `act` runs. */
async function main_thread_tasks(page, act) {
  const devtools = await page.context().newCDPSession(page);
  const events = [];
  devtools.on('Tracing.dataCollected', ({ value }) => events.push(...value));
  await devtools.send('Tracing.start', { transferMode: 'ReportEvents', traceConfig: { includedCategories: ['toplevel', 'devtools.timeline'], recordMode: 'recordAsMuchAsPossible' } });
  const result = await act();
  const complete = new Promise((resolve) => devtools.once('Tracing.tracingComplete', resolve));
  await devtools.send('Tracing.end');
  await complete;
  const threads = new Set(events.filter((e) => e.name === 'FireAnimationFrame').map((e) => `${e.pid} ${e.tid}`)); // the threads of pages
  return { result, tasks: events.filter((e) => e.ph === 'X' && e.tdur > 0 && e.name.includes('RunTask') && threads.has(`${e.pid} ${e.tid}`)).map((e) => e.tdur / 1000) };
}

/** @return times from the request to the frame (ms), the longest task of the main thread and the work of the programs for a jump (ms processor time) */
export const scrub = () =>
  with_studio(walkers(1, duration), async ({ page, service }) => {
    await page.waitForTimeout(settled_ms);
    const before = load_of(service.pid()).ticks;
    const { result: times, tasks } = await main_thread_tasks(page, () =>
      page.evaluate(([count, length]) =>
        new Promise((resolve) => {
          const socket = new WebSocket(`${location.origin.replace('http', 'ws')}/ws`, ['ugoki', `ugoki.token.${sessionStorage.getItem('ugoki_token')}`]);
          socket.binaryType = 'arraybuffer';
          const times = [];
          let [wanted, sent, seed] = [-1, 0, 1];
          const jump = () => {
            if (times.length === count) return resolve(times);
            seed = (seed * 48271) % 2147483647;
            wanted = Math.round((length * 60 * seed) / 2147483647) / 60;
            sent = performance.now();
            socket.send(JSON.stringify({ id: 10 + times.length, op: 'seek', time: wanted }));
          };
          socket.onopen = () => socket.send('{"id":1,"op":"hello"}');
          socket.onmessage = ({ data }) => {
            if (typeof data === 'string') {
              if (JSON.parse(data).reply === 1) jump();
            } else if (wanted >= 0 && Math.abs(new DataView(data).getFloat64(8, true) - wanted) < 1 / 100) {
              times.push(performance.now() - sent);
              wanted = -1;
              setTimeout(jump, 5);
            }
          };
        }), [jumps, duration]));
    return { times, longest_task_ms: Math.max(...tasks), programs_ms: (10 * (load_of(service.pid()).ticks - before)) / jumps };
  });

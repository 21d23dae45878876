// The service under test in a temporary folder: the program (UGOKI_BIN), or with UGOKI_MOCK=1 the mock service.
import { spawn, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = fileURLToPath(new URL('.', import.meta.url));
export const program = process.env.UGOKI_BIN ?? join(here, '../../build/release/bin/ugoki');
export const mock = process.env.UGOKI_MOCK === '1';

/** Folder of the built page. */
const web = process.env.UGOKI_WEB ?? join(here, '../dist');

export const available = mock || existsSync(program);

/** Starts the service and waits for the address that it prints. @param content file with the content of the project; absent: the sample content */
export async function start_service(content) {
  const folder = mkdtempSync(join(tmpdir(), 'ugoki-e2e-'));
  const env = { ...process.env, HOME: folder, XDG_DATA_HOME: join(folder, 'data'), XDG_CACHE_HOME: join(folder, 'cache'), XDG_CONFIG_HOME: join(folder, 'config'), XDG_STATE_HOME: join(folder, 'state') };
  let child;
  let start;
  if (mock) child = spawn(process.execPath, [join(here, '../dev/mock-server.mjs'), '0'], { env, cwd: folder });
  else {
    const project = join(folder, 'sample.ugoki');
    const made = spawnSync(program, ['new', project, ...(content ? ['--from', content] : [])], { env, cwd: folder, encoding: 'utf8' });
    if (made.status !== 0) throw new Error(`ugoki new ended with ${made.status}: ${made.stderr}${made.stdout}`);
    start = (port) => spawn(program, ['studio', project, '--port', port, '--no-open', '--web', web, '--library', join(folder, 'library.db')], { env, cwd: folder });
    child = start('0');
  }
  let output = '';
  const printed_address = () => new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`no address within 60 s; output: ${output}`)), 60000);
    const read = (data) => {
      output += data;
      const found = output.match(/http:\/\/127\.0\.0\.1:\d+\/#code=\S+/);
      if (!found) return;
      clearTimeout(timer);
      resolve(found[0]);
    };
    child.stdout.on('data', read);
    child.stderr.on('data', read);
    child.on('exit', (code) => reject(new Error(`the service ended with ${code}: ${output}`)));
  });
  const address = await printed_address();
  return {
    address,
    /** The temporary folder; journeys may write to it. */
    folder,
    /** Runs the program on the command line, with the folder and environment of the service. */
    run: (arguments_, input) => spawnSync(program, arguments_, { env, cwd: folder, encoding: 'utf8', input }),
    spawn: (arguments_) => spawn(program, arguments_, { env, cwd: folder, stdio: 'ignore' }),
    /**
     * Kills the service, waits `pause_ms` ms, and restarts it on the same port. @param new_key true: with a new key; all tokens become invalid
     * @return the newly printed address
     */
    restart: async (new_key, pause_ms) => {
      const ended = new Promise((resolve) => child.on('exit', resolve));
      child.kill('SIGKILL');
      await ended;
      if (new_key) rmSync(join(env.XDG_STATE_HOME, 'ugoki', 'studio.key'));
      await new Promise((resolve) => setTimeout(resolve, pause_ms));
      output = '';
      child = start(new URL(address).port);
      return printed_address();
    },
    output: () => output,
    pid: () => child.pid,
    /** Whether the program has ended. */
    ended: () => child.exitCode !== null || child.signalCode !== null,
    stop: () =>
      new Promise((resolve) => {
        child.on('exit', () => {
          rmSync(folder, { recursive: true, force: true });
          resolve();
        });
        child.kill('SIGTERM');
        setTimeout(() => child.kill('SIGKILL'), 5000).unref();
      }),
  };
}

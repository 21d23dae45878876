// The table of requests: more than 200 requests over HTTP and WebSocket, each with the status that it must get. None of them may reach a
// file outside of the page and the project, and the studio must answer a correct request afterwards.
import assert from 'node:assert/strict';
import { connect } from 'node:net';
import { mock } from './service.mjs';

/** Sends bytes on a new connection. @return the status and the text of the first answer; status 0: the connection was closed without one */
function send(port, bytes) {
  return new Promise((resolve) => {
    let text = '';
    const socket = connect(port, '127.0.0.1', () => socket.write(bytes));
    const done = () => {
      clearTimeout(timer);
      socket.destroy();
      resolve({ status: Number(/^HTTP\/1\.1 (\d+)/.exec(text)?.[1] ?? 0), text });
    };
    const timer = setTimeout(done, 8000);
    socket.on('data', (data) => {
      text += data.toString('latin1');
      const head = text.indexOf('\r\n\r\n');
      if (head < 0) return;
      const length = Number(/content-length: (\d+)/i.exec(text.slice(0, head))?.[1] ?? 0);
      if (text.startsWith('HTTP/1.1 101') || text.length >= head + 4 + length) done();
    });
    socket.on('end', done);
    socket.on('error', done);
  });
}

/** Rows [what, method, path, headers, body, expected status (a list: one of them)]. */
export function table(port, token) {
  const host = `127.0.0.1:${port}`;
  const good = { Host: host, Authorization: `Bearer ${token}` };
  const rows = [];
  const add = (what, path, status, { method = 'GET', headers = good, body = '' } = {}) => rows.push({ what, method, path, headers, body, status: [status].flat() });

  // access: each of these paths with eight kinds of headers
  const guarded = ['/api/library', '/api/library/tags', '/api/entry/x', '/api/thumbnail/x', '/api/mechanism/human', '/api/motion/human-walk', '/api/contacts/human-walk', '/api/export/csv', '/api/sweeps', '/api/sweeps/rows?table=x.db', '/api/sweeps/csv?table=x.db', '/api/sweeps/plot?table=x.db', '/api/reference-character', '/ws'];
  for (const path of guarded) {
    add('no token', path, 401, { headers: { Host: host } });
    add('wrong token', path, 401, { headers: { Host: host, Authorization: 'Bearer wrong' } });
    add('shorter token', path, 401, { headers: { Host: host, Authorization: `Bearer ${token.slice(0, -1)}` } });
    add('another scheme', path, 401, { headers: { Host: host, Authorization: `Basic ${token}` } });
    add('token in the query', `${path}${path.includes('?') ? '&' : '?'}token=${token}`, 401, { headers: { Host: host } });
    add('token in a cookie', path, 401, { headers: { Host: host, Cookie: `ugoki_${port}=${token}` } });
    add('foreign host', path, 403, { headers: { ...good, Host: 'evil.example' } });
    add('host of another port', path, 403, { headers: { ...good, Host: '127.0.0.1:1' } });
    add('foreign origin', path, 403, { headers: { ...good, Origin: 'http://evil.example' } });
    add('origin null', path, 403, { headers: { ...good, Origin: 'null' } });
  }
  // nothing outside of the page
  const outside = ['/..', '/../', '/../../etc/passwd', '/assets/../../etc/passwd', '/%2e%2e/%2e%2e/etc/passwd', '/..%2f..%2fetc/passwd', '/%2e%2e%5cetc', '/..\\..\\etc\\passwd', '/assets/%00', '/.git/config', '/.env',
    '/etc/passwd', '//etc/passwd', '/%2fetc%2fpasswd', '/assets/..;/index.html', '/....//....//etc/passwd', '/index.html/../../../etc/passwd', '/proc/self/environ', '/sample.ugoki', '/../sample.ugoki', '/library.db', '/assets/', '/gallery/', '/nothing.js', '/~root', '/%c0%ae%c0%ae/etc/passwd'];
  for (const path of outside) {
    add('outside of the page', path, [400, 403, 404], { headers: { Host: host } });
    add('outside of the page, with token', path, [400, 403, 404]);
  }
  for (const kind of ['mechanism', 'motion', 'entry', 'thumbnail', 'contacts'])
    for (const id of ['..%2f..%2fetc%2fpasswd', '%00', 'nothing', '', `${'a'.repeat(3000)}`, "'%20or%201=1", '%ff']) add('an id that does not exist', `/api/${kind}/${id}`, [400, 404]);
  for (const form of ['exe', '', '..%2fhtml', 'HTML']) add('a form of export that does not exist', `/api/export/${form}`, [400, 404]);
  for (const path of ['/api', '/api/', '/api/nothing', '/api/library/nothing', '/API/library']) add('not an address', path, [400, 404, 405]);
  // values out of range
  for (const query of ['limit=0', 'limit=501', 'limit=-1', 'limit=x', 'limit=1e9', 'order=random', 'kind=lsi', 'after=x']) add('a value out of range', `/api/library?${query}`, 400);
  for (const height of ['0', '-1', '3.1', 'x', 'nan', '1e300']) add('a height out of range', `/api/reference-character?height=${height}`, 400);
  // tables of results: only tables are read, wherever they are
  for (const kind of ['rows', 'csv', 'plot']) {
    for (const file of ['', 'nothing.db', '/etc/passwd', '../../../../etc/passwd', '..%2f..%2f..%2fetc%2fpasswd', '/proc/self/environ', '/dev/zero', '/', '.', '%00', 'x.db%00', `${'a'.repeat(5000)}`, 'sample.ugoki', 'library.db', 'file:///etc/passwd', 'sweep=nothing', "sweep=x';DROP TABLE runs"])
      add('a table that is not one', `/api/sweeps/${kind}?table=${file.replaceAll(' ', '%20').replaceAll("'", '%27')}&x=a&y=b`, [400, 404]);
    add('a request without a table', `/api/sweeps/${kind}`, [400, 404]);
  }
  add('not an address', '/api/sweeps/nothing?table=x.db', [400, 404]);
  add('the tables', '/api/sweeps', 200);
  // methods
  for (const method of ['PUT', 'DELETE', 'PATCH', 'OPTIONS', 'TRACE', 'CONNECT', 'FOO']) {
    add('another method', '/', [400, 404, 405, 501], { method, headers: { Host: host } });
    add('another method, with token', '/api/library', [400, 404, 405, 501], { method });
  }
  // bodies
  for (const body of ['', '{', '[]', 'null', '{"code": 3}', '{"code": ""}', '{"code": "wrong"}', `{"code": "${'a'.repeat(5000)}"}`, '{"token": "x"}'])
    add('a code that is not valid', '/api/session', [400, 401, 413], { method: 'POST', headers: { Host: host, 'Content-Type': 'application/json' }, body });
  for (const body of ['', '{', '{"base": "x"}', '{"base": -1}', '[1,2]']) add('a body that is not valid', '/api/entry/nothing', [400, 404], { method: 'POST', body });
  for (const name of ['', 'x', 'x.exe', 'x.bvh', '..%2fx.bvh', 'x.c3d', 'x.glb', 'x.fbx']) {
    add('a file that cannot be read', `/api/import/stage?name=${name}`, [400, 404, 413], { method: 'POST', body: 'not such a file' });
    add('a file without a token', `/api/import?name=${name}`, 401, { method: 'POST', headers: { Host: host }, body: 'x' });
  }
  for (const query of ['unit=0', 'unit=-1', 'unit=x', 'up=w', 'rate=0', 'rate=x', 'mapping=%7b', 'travel=2']) add('a setting out of range', `/api/import/stage?name=x.bvh&${query}`, 400, { method: 'POST', body: 'x' });
  for (const stage of ['nothing', '0', '-1', '..']) add('a file that was not staged', `/api/import/store/${stage}`, [400, 404], { method: 'POST' });
  add('the page', '/', 200, { headers: { Host: host } });
  add('the library', '/api/library', 200);
  add('the library, from the page', '/api/library', 200, { headers: { ...good, Origin: `http://${host}` } });
  return rows;
}

const request_of = ({ method, path, headers, body }) => {
  const lines = Object.entries({ ...headers, ...(body || method === 'POST' ? { 'Content-Length': Buffer.byteLength(body) } : {}), Connection: 'close' }).map(([k, v]) => `${k}: ${v}\r\n`);
  return `${method} ${path} HTTP/1.1\r\n${lines.join('')}\r\n${body}`;
};

/** Messages over the WebSocket, each with whether it must be refused. */
const messages = [
  '', '{', 'null', '[]', '3', '"x"', '{}', '{"id": 1}', '{"op": "hello"}', '{"id": 1, "op": 3}', '{"id": 1, "op": "nothing"}', '{"id": 1, "op": "command"}', '{"id": 1, "op": "command", "command": 3}',
  '{"id": 1, "op": "command", "command": {"type": "nothing"}}', '{"id": 1, "op": "command", "command": {"type": "clip.set", "character": "nobody", "id": "k1", "start": 1}}',
  '{"id": 1, "op": "command", "command": {"type": "scenario.set", "duration": -1}}', '{"id": 1, "op": "command", "command": {"type": "scenario.set", "duration": "long"}}', '{"id": 1, "op": "seek"}', '{"id": 1, "op": "seek", "time": -1}',
  '{"id": 1, "op": "seek", "time": 1e300}', '{"id": 1, "op": "mode", "mode": "dream"}', '{"id": 1, "op": "open", "path": "/etc/passwd"}', '{"id": 1, "op": "open", "path": "../../../etc/passwd"}', '{"id": 1, "op": "open", "path": ""}',
  '{"id": 1, "op": "new", "path": "/nowhere/at/all", "from": "empty"}', '{"id": 1, "op": "new", "path": "x", "from": "castle"}', '{"id": 1, "op": "new", "path": ".hidden", "from": "empty"}', '{"id": 1, "op": "save", "path": "/proc/x"}',
  '{"id": 1, "op": "motion"}', '{"id": 1, "op": "motion", "task": "t", "character": "human", "clip": "k1", "operation": "twist"}', '{"id": 1, "op": "pose", "character": "nobody"}', '{"id": 1, "op": "curves", "character": 3}',
  ...['gait', 'gaits', 'pose', 'poses', 'curves', 'joints', 'motion'].flatMap((op) => [`{"id": 1, "op": "${op}"}`, `{"id": 1, "op": "${op}", "character": "nobody"}`, `{"id": 1, "op": "${op}", "character": ["human"], "clip": {}}`]),
  '{"id": 1, "op": "gait", "task": "t", "character": "human", "gait": {"kind": "fly"}}', '{"id": 1, "op": "gait", "task": "t", "character": "human", "gait": {"kind": "walk", "speed": -1}}',
  '{"id": 1, "op": "gait", "task": "t", "character": "human", "gait": {"kind": "walk", "speed": 1e9}}', '{"id": 1, "op": "gait", "task": "t", "character": "human", "gait": {"kind": "walk", "duration": 1e9}}',
  '{"id": 1, "op": "gait", "task": "t", "character": "human", "gait": {"kind": "walk", "path": [[0, 0], [1e300, 0]]}}', '{"id": 1, "op": "gait", "task": 3, "character": "human", "gait": 7}',
  '{"id": 1, "op": "breakpoints", "list": 3}', '{"id": 1, "op": "breakpoints", "list": [{"condition": 3}]}', '{"id": 1, "op": "watch", "pins": 3}', '{"id": 1, "op": "remember", "choices": "dark"}', '{"id": 1, "op": "step", "frames": "x"}',
  '{"id": 1, "op": "grab", "character": "nobody", "link": 0, "point": [0, 0, 0], "target": [0, 0, 0]}', '{"id": 1, "op": "grab", "character": "human", "link": -1, "point": [0, 0], "target": 3}', '{"id": 1, "op": "push", "character": "human", "link": 1e9, "force": [1, 2, 3], "duration": 1}',
  '{"id": 1, "op": "play", "speed": -1}', '{"id": 1, "op": "play", "speed": "fast"}',
];

/** Opens a WebSocket by hand and sends text messages; @return the replies, in order, as text */
async function exchange(address, token, list) {
  const { WebSocket } = await import('ws');
  const socket = new WebSocket(`${address.replace('http', 'ws')}/ws`, ['ugoki', `ugoki.token.${token}`], { origin: address });
  const texts = [];
  socket.on('message', (data, binary) => binary || texts.push(String(data)));
  await new Promise((open, fail) => socket.on('open', open).on('error', fail));
  for (const text of list) socket.send(text);
  socket.send('{"id": 4711, "op": "hello"}');
  for (let i = 0; i < 400 && !texts.some((t) => t.includes('"reply":4711')); i++) await new Promise((wait) => setTimeout(wait, 25));
  socket.close();
  return texts;
}

export const request_journeys = [
  {
    name: 'requests: a table of more than 200 requests over HTTP and WebSocket gets the right answers, and nothing outside is reachable',
    skip: mock && 'the mock service accepts everybody',
    async run({ page, service }) {
      const { origin, port } = new URL(service.address);
      const token = await page.evaluate(() => sessionStorage.getItem('ugoki_token'));
      const rows = table(port, token);
      assert.ok(rows.length + messages.length >= 200, `${rows.length} requests, ${messages.length} messages`);
      const wrong = [];
      for (const row of rows) {
        const { status, text } = await send(Number(port), request_of(row));
        const line = `${row.what}: ${row.method} ${row.path.slice(0, 60)}`;
        if (!row.status.includes(status)) wrong.push(`${line}: ${status} instead of ${row.status.join(' or ')}`);
        if (/root:.*:0:0|BEGIN|SQLite format/.test(text)) wrong.push(`${line}: the content of a file outside`);
        if (status === 200 && !/content-security-policy: default-src 'none'|content-security-policy: default-src 'self'/i.test(text)) wrong.push(`${line}: no strict content-security policy`);
        if (status >= 400 && text.split('\r\n\r\n')[1]?.length < 10) wrong.push(`${line}: no explanation`);
      }
      const replies = await exchange(origin, token, messages);
      const refused = replies.filter((text) => /"error"|"ok":false/.test(text)).length;
      const hello = replies.find((text) => text.includes('"reply":4711'));
      if (!hello?.includes('"ok":true')) wrong.push('the studio does not answer after the messages');
      if (refused < messages.length - 8) wrong.push(`only ${refused} of ${messages.length} messages were refused: ${replies.join('\n').slice(0, 6000)}`);
      if (replies.some((text) => /root:.*:0:0/.test(text))) wrong.push('a message returned the content of a file');
      assert.deepEqual(wrong, []);
    },
  },
];

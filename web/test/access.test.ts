import { describe, expect, it, vi } from 'vitest';
import { Access, code_in, code_of, type AccessPlatform } from '../src/core/access';

/** A browser with the address `#fragment`, and a service that accepts `code` and `token`. */
function platform(fragment: string, service: { code: string; token: string; down?: boolean }, stored: Record<string, string> = {}) {
  const requests: { path: string; authorization: string | null; body: unknown }[] = [];
  const cleared = vi.fn();
  const p: AccessPlatform = {
    fragment: () => fragment,
    clear_fragment: () => {
      fragment = '';
      cleared();
    },
    storage: {
      getItem: (key) => stored[key] ?? null,
      setItem: (key, value) => void (stored[key] = value),
      removeItem: (key) => void delete stored[key],
    },
    fetch: (path, init = {}) => {
      const authorization = new Headers(init.headers).get('Authorization');
      requests.push({ path, authorization, body: init.body });
      if (service.down) return Promise.reject(new TypeError('Failed to fetch'));
      if (path === 'api/session') {
        const right = (JSON.parse(String(init.body)) as { code: string }).code === service.code;
        return Promise.resolve(right ? Response.json({ token: service.token }) : Response.json({ error: {} }, { status: 401 }));
      }
      return Promise.resolve(Response.json({}, { status: authorization === `Bearer ${service.token}` ? 200 : 401 }));
    },
  };
  return { access: new Access(p), requests, cleared, stored };
}

describe('a pasted address', () => {
  it('may be whole, a fragment, or only the code', () => {
    for (const text of ['http://127.0.0.1:7117/#code=c-1_2', '#code=c-1_2', ' c-1_2 ']) expect(code_in(text)).toBe('c-1_2');
  });
});

describe('Access', () => {
  it('exchanges the code of the address for the token and removes the code from the address', async () => {
    const { access, requests, cleared, stored } = platform('#code=c-1_2', { code: 'c-1_2', token: 't' });
    expect(await access.enter()).toBe('open');
    expect(cleared).toHaveBeenCalledOnce();
    expect(stored).toEqual({ ugoki_token: 't' });
    expect(requests[0]).toEqual({ path: 'api/session', authorization: null, body: '{"code":"c-1_2"}' });
    expect(requests.map((r) => r.path).join()).not.toContain('c-1_2');
    expect(access.subprotocols).toEqual(['ugoki', 'ugoki.token.t']);
  });

  it('sends the token in a header, with the other headers of the request', async () => {
    const { access, requests } = platform('', { code: 'c', token: 't' }, { ugoki_token: 't' });
    await access.fetch('api/import', { method: 'POST', body: 'x' });
    expect(requests.at(-1)).toEqual({ path: 'api/import', authorization: 'Bearer t', body: 'x' });
  });

  it('resumes with the token of the tab after a reload, and with an old address after a restart', async () => {
    expect(await platform('', { code: 'c', token: 't' }, { ugoki_token: 't' }).access.enter()).toBe('open');
    expect(await platform('#code=old', { code: 'new', token: 't' }, { ugoki_token: 't' }).access.enter()).toBe('open');
  });

  it('keeps the token while the service does not answer', async () => {
    const { access, stored } = platform('', { code: 'c', token: 't', down: true }, { ugoki_token: 't' });
    expect(await access.enter()).toBe('open');
    expect(stored).toEqual({ ugoki_token: 't' });
  });

  it('is refused without a code, with a wrong code and with a wrong token', async () => {
    expect(await platform('', { code: 'c', token: 't' }).access.enter()).toBe('refused');
    expect(await platform('#code=wrong', { code: 'c', token: 't' }).access.enter()).toBe('refused');
    const { access, stored } = platform('', { code: 'c', token: 't' }, { ugoki_token: 'wrong' });
    expect(await access.enter()).toBe('refused');
    expect(stored).toEqual({});
    expect(access.subprotocols).toEqual(['ugoki']);
  });

  it('reads the code of a fragment', () => {
    expect(code_of('#code=a-_b')).toBe('a-_b');
    expect(code_of('#')).toBeNull();
    expect(code_of('')).toBeNull();
    expect(code_of('#other=1')).toBeNull();
  });
});

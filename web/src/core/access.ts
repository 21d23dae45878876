/** The page's access to the service: exchanges the code of the page's address for a token, and sends the token with every request. */

/** The parts of the browser that `Access` uses, so that tests can replace them. */
export interface AccessPlatform {
  /** Fragment of the page's address with '#', or empty. */
  fragment(): string;
  /** Removes the fragment from the address bar and from the history's entry. */
  clear_fragment(): void;
  /** Storage of this tab; only pages of this origin can read it. */
  storage: Pick<Storage, 'getItem' | 'setItem' | 'removeItem'>;
  fetch(path: string, init?: RequestInit): Promise<Response>;
}

/** `open`: the page has a token. `refused`: it has none, or the service does not accept it. */
export type Entry = 'open' | 'refused';

const token_key = 'ugoki_token';

/** The code in a text that a user pasted: a whole address, its fragment, or the code alone. */
export const code_in = (text: string): string => code_of(text.slice(Math.max(0, text.indexOf('#')))) ?? text.trim();

/** The code in a fragment of the form `#code=CODE`; null if it contains none. */
export const code_of = (fragment: string): string | null => new URLSearchParams(fragment.replace(/^#/, '')).get('code');

export class Access {
  constructor(private readonly platform: AccessPlatform) {}

  /**
   * Exchanges the code of the page's address for the token; without a code, checks the token of this tab. To be called before other requests.
   * If the service does not answer, a token of this tab is kept: it is still valid after a restart of the service on the same port.
   */
  async enter(): Promise<Entry> {
    const code = code_of(this.platform.fragment());
    if (code === null) return this.check();
    this.platform.clear_fragment();
    return this.enter_code(code);
  }

  /** Exchanges `code` for the token. */
  async enter_code(code: string): Promise<Entry> {
    try {
      const response = await this.platform.fetch('api/session', { method: 'POST', body: JSON.stringify({ code }), headers: { 'Content-Type': 'application/json' } });
      const body = response.ok ? ((await response.json()) as { token?: unknown }) : {};
      if (typeof body.token === 'string') this.platform.storage.setItem(token_key, body.token);
    } catch {
      // the service does not answer
    }
    return this.check();
  }

  /** Asks the service whether it accepts the token of this tab. */
  async check(): Promise<Entry> {
    if (this.token === null) return 'refused';
    try {
      if ((await this.fetch('api/library?limit=1')).status !== 401) return 'open';
    } catch {
      return 'open'; // the service does not answer: the token is kept, and the client keeps trying to connect
    }
    this.platform.storage.removeItem(token_key);
    return 'refused';
  }

  /** `fetch` with the token in the header Authorization. */
  fetch(path: string, init: RequestInit = {}): Promise<Response> {
    const headers = new Headers(init.headers);
    if (this.token !== null) headers.set('Authorization', `Bearer ${this.token}`);
    return this.platform.fetch(path, { ...init, headers });
  }

  /** Subprotocols of the WebSocket. One of them carries the token, because a page cannot set the headers of a WebSocket. */
  get subprotocols(): string[] {
    return this.token === null ? ['ugoki'] : ['ugoki', `ugoki.token.${this.token}`];
  }

  private get token(): string | null {
    return this.platform.storage.getItem(token_key);
  }
}

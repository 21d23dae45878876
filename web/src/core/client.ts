/** The connection to the service: requests with answers, events, binary frames, and reconnection after a loss. */
import { RequestError, type HelloReply, type Request, type ServiceError, type ServiceEvent } from './protocol';
import { decode_frame, type Frame } from './frames';

/** The part of WebSocket that the client uses, so that tests can replace it. */
export interface SocketLike {
  binaryType: string;
  readyState: number;
  send(data: string): void;
  close(): void;
  onopen: ((event: unknown) => void) | null;
  onclose: ((event: { code: number }) => void) | null;
  onerror: ((event: unknown) => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
}

export interface ClientHandlers {
  connected(hello: HelloReply): void;
  /** @param retry_ms time until the next attempt to connect, ms */
  disconnected(retry_ms: number): void;
  event(event: ServiceEvent): void;
  frame(frame: Frame): void;
  /** Called with a sentence when a message does not follow the protocol. */
  protocol_error(message: string): void;
}

interface Waiting {
  resolve(reply: Record<string, unknown>): void;
  reject(error: Error): void;
}

const open_state = 1;

/** Delay before reconnection attempt `attempt` (from 0), ms: 250 ms, doubled at each attempt, at most 4000 ms. */
export const retry_delay = (attempt: number): number => Math.min(4000, 250 * 2 ** Math.min(attempt, 10));

export class Client {
  private socket: SocketLike | null = null;
  private next_id = 1;
  private attempt = 0;
  private closed = false;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private readonly waiting = new Map<number, Waiting>();
  /** Id of the newest request of each operation that the service answers only on failure (see post). */
  private readonly posted = new Map<string, number>();

  constructor(
    private readonly make_socket: () => SocketLike,
    private readonly handlers: ClientHandlers,
  ) {}

  connect(): void {
    if (this.timer) clearTimeout(this.timer);
    this.timer = null;
    const before = this.socket;
    this.socket = null;
    before?.close();
    const socket = this.make_socket();
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.request({ op: 'hello' }).then(
        (reply) => {
          this.attempt = 0;
          this.handlers.connected(reply as unknown as HelloReply);
        },
        (error: Error) => this.handlers.protocol_error(error.message),
      );
    };
    socket.onmessage = (message) => this.receive(message.data);
    socket.onerror = () => undefined; // nothing to do: a close event always follows an error event
    socket.onclose = () => this.lost(socket);
  }

  /** Reconnects now instead of at the end of the delay. */
  retry(): void {
    this.attempt = 0;
    this.closed = false;
    this.connect();
  }

  /** Closes the connection until the next `retry`. */
  close(): void {
    this.closed = true;
    if (this.timer) clearTimeout(this.timer);
    this.socket?.close();
  }

  get connected(): boolean {
    return this.socket?.readyState === open_state;
  }

  /** Sends a request. @return the reply; rejected with a RequestError if it is refused or the connection is lost */
  request(request: Request): Promise<Record<string, unknown>> {
    const socket = this.socket;
    if (!socket || socket.readyState !== open_state) {
      return Promise.reject(new RequestError(undefined, 'The studio is not connected; nothing was changed.'));
    }
    const id = this.next_id++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      socket.send(JSON.stringify({ id, ...request }));
    });
  }

  /**
   * Sends a request that the service answers only on failure. The client waits only for the newest request of each operation;
   * `failed` is called if that request fails.
   */
  post(request: Request, failed: (error: Error) => void): void {
    const socket = this.socket;
    if (!socket || socket.readyState !== open_state) return;
    const id = this.next_id++;
    const before = this.posted.get(request.op);
    if (before !== undefined) this.waiting.delete(before);
    this.posted.set(request.op, id);
    this.waiting.set(id, { resolve: () => undefined, reject: failed });
    socket.send(JSON.stringify({ id, ...request }));
  }

  private lost(socket: SocketLike): void {
    if (socket !== this.socket) return;
    this.socket = null;
    const error = new RequestError(undefined, 'The connection to the studio was lost before it answered.');
    for (const waiting of this.waiting.values()) waiting.reject(error);
    this.waiting.clear();
    if (this.closed) return;
    const delay = retry_delay(this.attempt++);
    this.handlers.disconnected(delay);
    this.timer = setTimeout(() => this.connect(), delay);
  }

  private receive(data: unknown): void {
    if (data instanceof ArrayBuffer) {
      const frame = decode_frame(data);
      if (typeof frame === 'string') this.handlers.protocol_error(frame);
      else this.handlers.frame(frame);
      return;
    }
    let message: Record<string, unknown>;
    try {
      message = JSON.parse(String(data)) as Record<string, unknown>;
    } catch {
      this.handlers.protocol_error('The studio sent a message that is not JSON.');
      return;
    }
    if (typeof message.reply === 'number') {
      const waiting = this.waiting.get(message.reply);
      this.waiting.delete(message.reply);
      if (!waiting) return;
      if (message.ok === true) waiting.resolve(message);
      else waiting.reject(new RequestError(message.error as ServiceError, 'The studio refused this without a reason.'));
    } else if (typeof message.event === 'string') {
      this.handlers.event(message as unknown as ServiceEvent);
    } else if (message.ok === false) {
      this.handlers.protocol_error(new RequestError(message.error as ServiceError, 'The studio reported an error.').message);
    }
  }
}

/**
 * Sends the latest of many values, one at a time. While one value is being sent, a newer value replaces the waiting one.
 * Used for seeking and dragging.
 */
export class LatestOnly<T> {
  private busy = false;
  private pending: { value: T } | null = null;

  constructor(
    private readonly send: (value: T) => Promise<unknown>,
    private readonly failed: (error: Error) => void,
  ) {}

  offer(value: T): void {
    this.pending = { value };
    if (!this.busy) this.next();
  }

  /** Whether a value has not been sent yet. */
  get waiting(): boolean { return this.pending !== null; }

  /** Discards the value that has not been sent yet. */
  drop(): void {
    this.pending = null;
  }

  private next(): void {
    const pending = this.pending;
    if (!pending) return;
    this.pending = null;
    this.busy = true;
    this.send(pending.value)
      .catch((error: Error) => this.failed(error))
      .finally(() => {
        this.busy = false;
        this.next();
      });
  }
}

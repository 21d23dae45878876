/**
 * Moves of the playhead that the service has not answered yet. An edit at the playhead may follow a move at once; a time that the service reports
 * meanwhile, of an earlier move or of changed content, must not take the playhead back.
 */
export class UnconfirmedMoves {
  private waiting = 0;
  private reported: number | null = null;

  /** @param more whether another move will be sent  @param show shows the playhead at a time, s */
  constructor(
    private readonly more: () => boolean,
    private readonly show: (time: number) => void,
  ) {}

  /** Waits for the answer to a request that moves the playhead. After the last one, the time that the service reported last is shown. */
  async add<T>(request: Promise<T>): Promise<T> {
    this.waiting++;
    return request.finally(() => {
      if (--this.waiting > 0 || this.more()) return;
      if (this.reported !== null) this.show(this.reported);
      this.reported = null;
    });
  }

  /** @param time reported by the service, s  @return true while a move is unanswered: the page keeps its own time */
  hides(time: number): boolean {
    if (this.waiting === 0) return false;
    this.reported = time;
    return true;
  }

  /** The time that was reported before no longer counts, because playing began or the mode changed. */
  forget(): void {
    this.reported = null;
  }
}

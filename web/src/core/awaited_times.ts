/**
 * Times to which the page moved the playhead and which the service has not confirmed yet. An edit at the playhead may follow at once; a
 * confirmation of an earlier move must not take the playhead back meanwhile.
 */
export class AwaitedTimes {
  private times: number[] = [];

  /** The page moved the playhead to `time`, s. */
  add(time: number): void {
    this.times.push(time);
  }

  clear(): void {
    this.times = [];
  }

  /** @param time reported by the service, s  @return true while later moves of the page are unconfirmed: the reported time is old. Any other time than an awaited one is taken. */
  is_old(time: number): boolean {
    const at = this.times.findIndex((awaited) => Math.abs(awaited - time) < 1e-6);
    this.times = at < 0 ? [] : this.times.slice(at + 1);
    return this.times.length > 0;
  }
}

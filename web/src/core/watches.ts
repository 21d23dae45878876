/** What the page asks the service to send while the content runs: the outputs that panels show, and the closest pairs of the viewport. */
import type { Request } from './protocol';

export class Watches {
  circuit: { pins: string[]; probes: string[]; timing: boolean } = { pins: [], probes: [], timing: false };
  /** Outputs whose values the rules panel shows. */
  rules: string[] = [];
  /** Outputs with the values of variables that the viewport shows. */
  variables: string[] = [];
  /** Outputs whose curves the plots panel shows. */
  plots: string[] = [];
  /** The request that was sent last, as JSON; empty if it must be sent again. */
  private sent = '';

  /** The `watch` request; null if it equals the one sent before. @param closest whether the viewport shows closest pairs */
  change(closest: boolean): Request | null {
    const both = (a: string[], b: string[]): string[] => [...new Set([...a, ...b])];
    const request: Request = { op: 'watch', ...this.circuit, pins: both(both(this.circuit.pins, this.rules), this.variables), probes: both(this.circuit.probes, this.plots), closest };
    const text = JSON.stringify(request);
    if (text === this.sent) return null;
    this.sent = text;
    return request;
  }

  /** Sends the request again at the next change: the service has failed, or is a new one. */
  forget(): void {
    this.sent = '';
  }
}

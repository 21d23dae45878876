/** A request over HTTP whose answer is JSON. */
import { RequestError, type ServiceError } from './protocol';

/**
 * Asks the service for JSON.
 * @param ask fetch of the page, with its token
 * @throws RequestError with the reasons of the service, or one that states that the service does not answer
 */
export async function fetch_json<T>(ask: (path: string, init?: RequestInit) => Promise<Response>, path: string, init?: RequestInit): Promise<T> {
  let response: Response;
  try {
    response = await ask(path, init);
  } catch {
    throw new RequestError({ problems: [{ message: 'The studio does not answer.', remedy: 'Check that `ugoki studio` is running.' }] }, '');
  }
  const text = await response.text();
  let body: unknown;
  try {
    body = JSON.parse(text);
  } catch {
    throw new RequestError(undefined, text.trim().slice(0, 300) || `The studio answered ${response.status} without a reason.`);
  }
  if (!response.ok) throw new RequestError((body as { error?: ServiceError }).error, `The studio answered ${response.status}.`);
  return body as T;
}

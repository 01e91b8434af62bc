// The server that gave this page, `cxlab view`: everything is asked there (docs/reference/view.md).

/**
 * @typedef {{ t: number, env: string, rule: string|null, facts: string[], firing: number|null, at_end: boolean, live: boolean,
 *   running: boolean, text: string }} Stand  where rules are asked
 * @typedef {{ kind: string, name?: string, n?: number }} Doer
 * @typedef {{ n: number, t_s: number, what: string, by: Doer, text: string }} Change
 * @typedef {{ fact?: string, template: string, slots: Object<string, any>, present: boolean, changes: Change[] }} Fact
 */

const BUSY = 409, TRIES = 40, PAUSE_MS = 250;
const later = (/** @type {number} */ ms) => new Promise((done) => setTimeout(done, ms));

async function answerOf(/** @type {string} */ path, /** @type {any} */ body, /** @type {AbortSignal|undefined} */ signal = undefined) {
  const request = body === undefined ? { signal } : { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) };
  try {
    return await fetch(path, request);
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new Error('The server does not answer. Start cxlab view again and open the address that it prints.');
  }
}

/** The JSON that the server answers; with a body it is sent there. An error is what the server says about it. */
export async function request(/** @type {string} */ path, /** @type {any} */ body = undefined, /** @type {AbortSignal|undefined} */ signal = undefined) {
  for (let tries = 1;; ++tries) {
    const response = await answerOf(path, body, signal);
    const said = await response.json().catch(() => ({ error: 'The answer to ' + path + ' is no JSON.' }));
    if (response.ok && !said.error) return said;
    if (response.status !== BUSY || tries === TRIES) throw new Error(said.error || 'The server answers ' + response.status + '.');
    await later(PAUSE_MS);
  }
}

/** Bytes; null where there are none. */
export async function bytesOf(/** @type {string} */ path) {
  const response = await answerOf(path, undefined);
  const bytes = new Uint8Array(await response.arrayBuffer());
  return response.ok && bytes.length ? bytes : null;
}

const loadScript = (/** @type {string} */ address) => new Promise((done, failed) => {
  const script = document.createElement('script');
  Object.assign(script, { src: address, onload: () => done(undefined), onerror: () => failed(new Error(address + ' cannot be loaded')) });
  document.head.append(script);
});

/** @type {any} */ (window).cxlabSource = { run: () => request('data.json'), scene: () => bytesOf('scene.bin'), three: () => loadScript('/three.js') };

// In a frame beside another run the page around it has slider and keys.
if (new URLSearchParams(location.search).has('beside')) document.documentElement.dataset.beside = 'true';

/** Calls one after the other. One that nobody wants any more when its turn comes is left out. */
export class Turns {
  constructor() {
    /** @type {Promise<any>} */
    this.last = Promise.resolve();
  }
  /** @returns {Promise<any>} undefined where `wanted` says no */
  take(/** @type {() => Promise<any>} */ call, /** @type {() => boolean} */ wanted = () => true) {
    const turn = this.last.catch(() => {}).then(() => (wanted() ? call() : undefined));
    this.last = turn;
    return turn;
  }
}

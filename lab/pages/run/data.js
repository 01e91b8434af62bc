// Where the page has its run from: from itself. A program that serves the page may set `window.cxlabSource` to an object with
// the same three functions before this script runs; `three` runs three.js.

/**
 * @typedef {{ shape: string, kind: string, begin: number, end: number, text: string, remark?: string, task?: string }} Bar
 * @typedef {{ kind: string, t: number, text: string }} Mark
 * @typedef {{ name: string, bars: Bar[], marks: Mark[] }} Lane
 * @typedef {{ text: string, where?: string, begin: number|null, end: number|null, waited_s: number, reason?: string }} Step
 * @typedef {{ id: string, name: string, kind?: string, text: string, look?: string, known: number, begin: number, end: number,
 *   begun: number|null, done: number|null, state: string, state_kind: string, late_s: number, waited_s: number,
 *   points: number|null, reason: string, steps: Step[], word?: string }} Task
 * @typedef {{ kind: string, text: string, part: boolean, steps: [number, number][] }} Line
 * @typedef {{ t: number|null, kind: string, text: string, who?: string, reason?: string, task?: string }} RunEvent
 * @typedef {{ type: string, title: string, word?: string, key?: {kind: string, text: string}[], lanes?: Lane[], tasks?: Task[],
 *   lines?: Line[] }} Part
 * @typedef {{ name: string, fill: string, ink: string, hatched: boolean }} Kind
 * @typedef {{ end: number, kinds: Kind[], shades: {kind: string, begin: number, end: number, text: string}[], parts: Part[],
 *   events: RunEvent[] }} Run
 * @typedef {{ run: () => Promise<Run>, scene: () => Promise<Uint8Array|null>, three: () => Promise<void> }} Source
 */

/** The bytes of a text in base64 that gzip has compressed. */
async function unpack(/** @type {string} */ text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new (/** @type {any} */ (window).DecompressionStream)('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function bytesIn(/** @type {string} */ id) {
  const element = document.getElementById(id);
  return element ? unpack(element.textContent || '') : null;
}

const decode = (/** @type {Uint8Array|null} */ bytes) => new TextDecoder().decode(bytes || new Uint8Array());

/** @type {Source} */
export const source = /** @type {any} */ (window).cxlabSource || {
  run: async () => JSON.parse(decode(await bytesIn('run-data'))),
  scene: () => bytesIn('run-scene'),
  three: async () => {
    const script = document.createElement('script');
    script.append(decode(await bytesIn('three-js')));
    document.head.append(script);
  },
};

/** What a program that serves the page adds to it: called with the page when all its parts are there.
 * @type {((page: import('./main.js').Page) => void)[]} */
export const additions = [];

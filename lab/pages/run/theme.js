// Light or dark.

import { el } from './draw.js';

/** Remembers a setting where the browser allows it. */
const memory = {
  get: (/** @type {string} */ key) => { try { return localStorage.getItem(key); } catch (error) { return null; } },
  set: (/** @type {string} */ key, /** @type {string} */ value) => { try { localStorage.setItem(key, value); } catch (error) { /* it is forgotten */ } },
};

/** Light, dark, or as the system has it. */
export function themeButton(/** @type {() => void} */ changed) {
  const names = ['auto', 'light', 'dark'];
  const button = el('button', { type: 'button', title: 'light or dark (d)', onclick: () => show(names[(names.indexOf(shown) + 1) % names.length]) });
  let shown = memory.get('cxlab-theme') || 'auto';
  const show = (/** @type {string} */ name) => {
    shown = names.includes(name) ? name : 'auto';
    memory.set('cxlab-theme', shown);
    document.documentElement.dataset.theme = shown;
    button.textContent = shown;
    changed();
  };
  show(shown);
  return button;
}

// Elements, icons and formatted numbers. Text only ever enters the page through createTextNode.

const SVG = 'http://www.w3.org/2000/svg';

/** Make an element: el('p', {class: 'x', onclick: f, 'aria-label': 'y'}, 'text', child, …). */
function el(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : plainText(value));
  }
  append(element, children);
  return element;
}

function append(parent, children) {
  for (const child of children.flat(2)) {
    if (child === null || child === undefined || child === false) continue;
    parent.append(child instanceof Node ? child : document.createTextNode(plainText(child)));
  }
}

// Terminal colours, control characters, and the bidi controls that make a line read backwards.
const INVISIBLE = /\x1b\[[0-?]*[ -/]*[@-~]|[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]/g;
const plainText = (value) => String(value).replace(INVISIBLE, '');

function replaceChildren(parent, ...children) {
  parent.replaceChildren();
  append(parent, children);
}

// Stroked 24 x 24 paths; 'f:' before a path means filled.
const ICONS = {
  play: ['f:M8 5.2v13.6a.8.8 0 0 0 1.2.7l10.6-6.8a.8.8 0 0 0 0-1.4L9.2 4.5A.8.8 0 0 0 8 5.2z'],
  pause: ['f:M7 5h3.5v14H7z', 'f:M13.5 5H17v14h-3.5z'],
  stepBack: ['M16 6l-6 6 6 6', 'M7 6v12'],
  stepForward: ['M8 6l6 6-6 6', 'M17 6v12'],
  momentBack: ['M13 6l-6 6 6 6', 'f:M17.5 8.5l3.5 3.5-3.5 3.5-3.5-3.5z'],
  momentForward: ['M11 6l6 6-6 6', 'f:M6.5 8.5l3.5 3.5-3.5 3.5L3 12z'],
  fit: ['M4 9V4h5', 'M15 4h5v5', 'M20 15v5h-5', 'M9 20H4v-5'],
  plus: ['M12 5v14', 'M5 12h14'],
  minus: ['M5 12h14'],
  follow: ['M12 2v4', 'M12 18v4', 'M2 12h4', 'M18 12h4', 'M12 7a5 5 0 1 0 0 10 5 5 0 0 0 0-10z'],
  lidar: ['M12 19L4.5 8a10 10 0 0 1 15 0z', 'M8.3 13.5a5 5 0 0 1 7.4 0'],
  theme: ['M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z', 'f:M12 3a9 9 0 0 1 0 18z'],
  help: ['M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.2-1.5 2.4', 'M12 17.5v.2'],
  pass: ['M5 12.5l4.5 4.5L19 7.5'],
  fail: ['M6.5 6.5l11 11', 'M17.5 6.5l-11 11'],
  skip: ['M6 12h12'],
  unavailable: ['M6 12h12'],
  error: ['M12 5v9', 'M12 18v.5'],
  inconclusive: ['M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.2-1.5 2.4', 'M12 17.5v.2'],
  badge: ['M12 3l7 2.5v5.5c0 4.5-3 8-7 10-4-2-7-5.5-7-10V5.5z', 'M8.5 12l2.5 2.5 4.5-5'],
  badgeEmpty: ['M12 3l7 2.5v5.5c0 4.5-3 8-7 10-4-2-7-5.5-7-10V5.5z'],
  close: ['M6 6l12 12', 'M18 6L6 18'],
};

function icon(name) {
  const svg = document.createElementNS(SVG, 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  for (const source of ICONS[name] || ICONS.help) {
    const filled = source.startsWith('f:');
    const path = document.createElementNS(SVG, 'path');
    path.setAttribute('d', filled ? source.slice(2) : source);
    path.setAttribute('class', filled ? 'icon-fill' : 'icon-line');
    svg.append(path);
  }
  return svg;
}

/** A button with an icon; its name is in aria-label and in the tooltip. */
function iconButton(name, label, onclick, properties = {}) {
  return el('button', { type: 'button', class: 'icon-button', 'aria-label': label,
    title: label, onclick, ...properties }, icon(name));
}

function setIcon(button, name, label) {
  if (button.dataset.icon === name) return;
  button.dataset.icon = name;
  button.replaceChildren(icon(name));
  button.setAttribute('aria-label', label);
  button.title = label;
}

const MINUS = '\u2212';

function fixed(value, digits = 2) {
  if (!Number.isFinite(value)) return '\u2013';
  const text = value.toFixed(digits);
  if (Number(text) === 0) return text.replace('-', '');
  return text.replace('-', MINUS);
}

function withUnit(value, unit, digits = 2) {
  return Number.isFinite(value) ? `${fixed(value, digits)}\u00a0${unit}` : 'unknown';
}

const seconds = (t, digits = 2) => withUnit(t, 's', digits);
const degrees = (radians) => withUnit((radians * 180) / Math.PI, '\u00b0', 0).replace('\u00a0', '');
const plural = (n, one, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;
const QUANTITY = /(?:[-\u2212]?\d[\d.]*[ \u00a0])?(?:m\/s\u00b2?|rad\/s|km\/h)(?!\w)|[-\u2212]?\d[\d.]*[ \u00a0](?:ms|s|m|Hz|rad|%)(?!\w)/g;

/** Text as children for `el`: no line ends within a number with its unit, nor within "m/s". */
function unbroken(value) {
  const said = text(value);
  const pieces = [];
  let end = 0;
  for (const { 0: quantity, index } of said.matchAll(QUANTITY)) {
    pieces.push(said.slice(end, index), el('span', { class: 'quantity' }, quantity));
    end = index + quantity.length;
  }
  return [...pieces, said.slice(end)];
}

const text = (value) => (value === null || value === undefined ? '' : String(value));
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

function calmMotion() {
  return matchMedia('(prefers-reduced-motion: reduce)').matches;
}

/** Colours of CSS custom properties as a canvas wants them (light-dark() resolved). */
function readColours(element, names) {
  const probe = el('span', { hidden: true });
  element.append(probe);
  const colours = {};
  for (const name of names) {
    probe.style.color = `var(--${name})`;
    colours[name] = getComputedStyle(probe).color;
  }
  probe.remove();
  return colours;
}

/** Match the canvas's pixels to the screen's; returns its size in CSS pixels. */
function sizeCanvas(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 3);
  const { width, height } = canvas.getBoundingClientRect();
  const w = Math.max(1, Math.round(width * ratio));
  const h = Math.max(1, Math.round(height * ratio));
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  canvas.getContext('2d').setTransform(ratio, 0, 0, ratio, 0, 0);
  return { width, height };
}

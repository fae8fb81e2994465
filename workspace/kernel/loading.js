// Say how much of Python is there while cells wait for it, and keep what came before the service worker did (offline.js).

const SIZES = {}; // [bytes] by name, of what a kernel loads; workspace/lite.py fills them in
const HERE = new URL('.', import.meta.url);
const line = document.createElement('p');
line.id = 'course-loading';
line.setAttribute('role', 'status');
line.style = 'position: fixed; bottom: 0; left: 0; right: 0; z-index: 1001; margin: 0; padding: 8px 16px; background: #234; color: #fff; font: 16px sans-serif';
const loaded = new Set();
let missing = '';

const size = (names) => (names.reduce((sum, name) => sum + SIZES[name], 0) / 1e6).toFixed(0);

function words() {
  if (missing) return `No network, and this browser has not kept ${missing}: visit the page once with a network, and let its first cell end.`;
  if (!globalThis.jupyterapp) return 'The notebook is loading.';
  const all = Object.keys(SIZES);
  if (loaded.size === all.length) return 'Python is starting. Cells wait for it.';
  return `Python is loading: ${loaded.size ? `${size([...loaded])} of ` : ''}${size(all)} MB. Cells wait for it.`;
}

// What came before the service worker did, what the pages' worker will load, and at last the page: with it a visit needs no network.
async function keep() {
  // The worker's address lies outside of this service worker's reach. Without its version JupyterLite ends both at the next visit
  const { appVersion } = JSON.parse(document.querySelector('#jupyter-config-data').textContent);
  localStorage.setItem(`${navigator.serviceWorker.controller?.scriptURL}-version`, appVersion);
  await navigator.serviceWorker.register(new URL('../offline.js', HERE));
  const store = await caches.open('course-notebooks');
  const before = performance.getEntriesByType('resource').map(({ name }) => name).filter((name) => name.startsWith(HERE));
  const files = await (await fetch(new URL('../_static/workspace/manifest.json', HERE))).json();
  const later = Object.entries(files).map(([name, { sha256 }]) => new URL(`../_static/workspace/${name}?${sha256}`, HERE).href);
  const { content } = await (await fetch(new URL('api/contents/all.json', HERE))).json();
  const notebooks = content.map(({ path }) => new URL(`files/${path}`, HERE).href);
  await Promise.all([...new Set([...before, ...later, ...notebooks])].map((name) => store.add(name).catch(() => {})));
  await store.add(location.href);
}

navigator.serviceWorker?.addEventListener('message', ({ data: { kind, address } }) => {
  const [name] = String(address).slice(HERE.href.length).split(/[?#]/);
  if (kind === 'loaded' && name in SIZES) loaded.add(name);
  if (kind === 'missing' && address.startsWith(HERE)) missing = name;
});
document.body.append(line);
const clock = setInterval(() => {
  const kernel = globalThis.jupyterapp?.shell.currentWidget?.sessionContext?.session?.kernel;
  const isThere = ['idle', 'busy'].includes(kernel?.status);
  line.textContent = words();
  if (!isThere) return;
  clearInterval(clock);
  line.remove();
  if (navigator.serviceWorker) keep().catch(() => {}); // no room, or no network: what was kept stays
}, 200);

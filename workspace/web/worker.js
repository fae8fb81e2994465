// Python in a worker, of files that `make workspace` has made. Once it is warm its memory is copied; each call begins from that copy.

const FOLDER = '/home/reader'; // of the node
const RECORDINGS = '/recordings';
const [LINES, LONGEST] = [2000, 2000]; // shown of what a call prints, and [characters] of each
let python;
let image;
let top; // of the stack, when the image was made
const calls = {}; // methods of workspace.runtime.Runtime

const CACHE = 'course-workspace'; // also in keep.js
const PLAIN = { 'pyodide.asm.wasm': 'application/wasm', 'python_stdlib.zip': 'application/zip' };

/** Fetch a file of the workspace, or have it from this browser's store: its address holds its hash. */
const stored = async (name, manifest) => {
  const { sha256 } = manifest[name];
  const address = `${name}?${sha256}`;
  const store = await globalThis.caches?.open(CACHE).catch(() => null); // none without https, or in a private window
  const kept = await store?.match(address).catch(() => null);
  if (kept && await isRight(kept, sha256)) return kept;
  for (const cache of ['default', 'reload']) { // what the browser itself keeps may be wrong as well
    const answer = await fetch(address, { cache }); // eslint-disable-line no-await-in-loop
    if (!answer.ok) throw new Error(`${name}: the server answers ${answer.status} ${answer.statusText}. Reload the page.`);
    if (await isRight(answer, sha256)) { // eslint-disable-line no-await-in-loop
      store?.put(address, answer.clone()).catch(() => {}); // no room: it works without
      return answer;
    }
  }
  throw new Error(`${name}: the server sends something else, perhaps a page to log in. Open it in a tab of its own, then reload this one.`);
};

/** Return whether an answer is whole, and the file that the site was built with. Only https has hashes, as it has a store. */
async function isRight(answer, sha256) {
  if (!globalThis.crypto?.subtle) return true;
  const hash = new Uint8Array(await crypto.subtle.digest('SHA-256', await answer.clone().arrayBuffer()));
  return Array.from(hash, (byte) => byte.toString(16).padStart(2, '0')).join('') === sha256;
}

/** Return an answer whose content was compressed when the page was built: plain servers compress nothing. */
const inflated = (packed, type = '') => new Response(packed.body.pipeThrough(new DecompressionStream('gzip')),
  { headers: { 'Content-Type': type } });

const script = async (answer) => URL.createObjectURL(new Blob([await answer.arrayBuffer()], { type: 'text/javascript' }));

/** Unpack a tar archive into /course; Python's own takes ten times as long. */
function unpack(archive) {
  const [text, folders] = [new TextDecoder(), new Set()];
  for (let at = 0; archive[at];) {
    const field = (from, size) => text.decode(archive.subarray(at + from, at + from + size)).split('\0')[0];
    const path = ['/course', field(345, 155), field(0, 100)].filter(Boolean).join('/');
    const folder = path.slice(0, path.lastIndexOf('/'));
    if (!folders.has(folder)) python.FS.mkdirTree(folder);
    folders.add(folder);
    const end = at + 512 + parseInt(field(124, 12), 8);
    python.FS.writeFile(path, archive.subarray(at + 512, end), { canOwn: true });
    at = 512 * Math.ceil(end / 512);
  }
}

const fail = (error) => postMessage({ kind: 'error', text: String(error && error.message ? error.message : error).slice(-4000) });
const say = (text) => postMessage({ kind: 'progress', text });

let lines; // that this call has printed
const print = (text) => {
  lines += 1;
  if (lines <= LINES) postMessage({ kind: 'out', text: text.slice(0, LONGEST) });
  if (lines === LINES + 1) postMessage({ kind: 'out', text: '… and more, which is not shown' });
};

/** Take from Python what reaches this site or its store: the code that it runs may have come in a link. */
function forgetTheSite() {
  const names = [
    'caches', 'indexedDB', 'fetch', 'XMLHttpRequest', 'WebSocket', 'WebSocketStream', 'WebTransport', 'EventSource',
    'BroadcastChannel', 'Worker', 'importScripts', 'navigator',
  ];
  for (let holder = globalThis; holder; holder = Object.getPrototypeOf(holder)) names.forEach((name) => delete holder[name]);
}

async function load(manifest) {
  say('Fetching Python, 12 MB the first time …');
  const names = Object.keys(manifest).filter((name) => /^(course|packages)\.pack$|^pyodide\//.test(name));
  const files = Object.fromEntries(names.map((name) => [name, stored(name, manifest)]));
  Promise.all(Object.values(files)).catch(fail); // what waits for a file of Pyodide's would wait for ever
  importScripts(await script(await files['pyodide/pyodide.js']), await script(inflated(await files['pyodide/pyodide.asm.js.pack'])));
  const plainFetch = globalThis.fetch;
  globalThis.fetch = async (url, options) => {
    const name = String(url).split('/').at(-1);
    const packed = files[`pyodide/${name}.pack`];
    return packed ? inflated(await packed, PLAIN[name]) : files[`pyodide/${name}`] || plainFetch(url, options);
  };
  python = await loadPyodide({
    indexURL: './pyodide/',
    stdout: print,
    stderr: print,
    stdin: () => null, // its end: nobody types here
    env: {
      HOME: '/home', LANG: 'C.UTF-8', PYTHONHASHSEED: '0', PYTHONDONTWRITEBYTECODE: '1', ROS_DISTRO: 'jazzy',
      ROS_AUTOMATIC_DISCOVERY_RANGE: 'OFF', _ROS_WHEELS_BOOTSTRAP_COMPLETE: '1',
    },
  });
  globalThis.fetch = plainFetch;
  const packs = await Promise.all(['packages.pack', 'course.pack'].map((name) => files[name]));
  forgetTheSite(); // what came wrong has been asked for again by now
  for (const pack of packs) unpack(new Uint8Array(await inflated(pack).arrayBuffer()));
  [FOLDER, RECORDINGS].forEach((folder) => python.FS.mkdirTree(folder));
  say('Starting rclpy, the robot and the judge …');
  globalThis.reached = (seconds) => postMessage({ kind: 'reached', seconds });
  python.runPython(`
import sys
sys.path[:0] = ["/course", "/course/workspace/page_packages"]
from workspace import runtime
from js import reached, stacks
from pyodide.ffi import run_sync

class Browser:
    begin, wake = stacks.begin, stacks.wake
    wait = staticmethod(lambda number: run_sync(stacks.waited(number)))

page = runtime.warm("${RECORDINGS}", reached, ${threads ? 'Browser' : 'None'})
`);
  const page = python.globals.get('page');
  for (const name of ['trial', 'drive', 'judge', 'replay', 'race', 'thread']) calls[name] = page[name];
  image = python._module.HEAPU8.slice();
  top = python._module.stackSave();
}

const threads = 'Suspending' in WebAssembly; // stacks that wait for a promise
const waiting = new Map(); // how to wake them, by their numbers
globalThis.stacks = {
  begin: (number) => queueMicrotask(() => calls.thread.callPromising(number).catch(fail)),
  waited: (number) => new Promise((resolve) => { waiting.set(number, resolve); }),
  wake: (number) => { waiting.get(number)(); waiting.delete(number); },
};

function restore() {
  const memory = python._module.HEAPU8;
  memory.set(image);
  memory.fill(0, image.length);
  python._module.stackRestore(top);
  waiting.clear();
}

/** Let a folder hold these files, texts or bytes, and nothing else. */
function fill(folder, files) {
  for (const old of python.FS.readdir(folder)) if (!old.startsWith('.')) python.FS.unlink(`${folder}/${old}`);
  for (const [name, content] of Object.entries(files)) python.FS.writeFile(`${folder}/${name}`, content);
}

/** What a call needs of files comes with it, and what it made of them goes with the answer. */
async function answer(call, order, files, recordings) {
  fill(FOLDER, files);
  fill(RECORDINGS, recordings);
  restore();
  lines = 0;
  const isTrial = call === 'trial' || call === 'drive';
  const said = threads && isTrial ? await calls[call].callPromising(JSON.stringify(order)) : calls[call](JSON.stringify(order));
  const made = isTrial ? python.FS.readdir(RECORDINGS).filter((name) => !name.startsWith('.')) : [];
  const contents = Object.fromEntries(made.map((name) => [name, python.FS.readFile(`${RECORDINGS}/${name}`)]));
  postMessage({ kind: 'answer', said, recordings: contents }, Object.values(contents).map(({ buffer }) => buffer));
}

onmessage = async ({ data: { call, manifest, order, files, recordings } }) => {
  try {
    if (call !== 'load') await answer(call, order, files, recordings);
    else {
      await load(manifest);
      postMessage({ kind: 'answer' });
    }
  } catch (error) {
    fail(error);
  }
};

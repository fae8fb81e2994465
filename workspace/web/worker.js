// Python in a worker, of files that `make workspace` has made. Once it is warm its memory is copied; each call begins from that copy.

const FOLDER = '/home/reader'; // of the node
const RECORDINGS = '/recordings';
let python;
let image;
const calls = {}; // methods of workspace.runtime.Runtime

const bytes = async (name) => {
  const answer = await fetch(name);
  if (!answer.ok) throw new Error(`${name}: ${answer.status} ${answer.statusText}`);
  return answer.arrayBuffer();
};

/** Fetch a file that was compressed when the page was built: plain servers compress nothing. */
const inflated = async (name, type) => {
  const packed = new Response(await bytes(`${name}.pack`));
  return new Response(packed.body.pipeThrough(new DecompressionStream('gzip')), { headers: { 'Content-Type': type } });
};

const say = (text) => postMessage({ kind: 'progress', text });

async function load() {
  say('Fetching Python, 12 MB the first time …');
  const packs = Promise.all(['packages.pack', 'course.pack'].map(bytes));
  importScripts('pyodide/pyodide.js', URL.createObjectURL(await (await inflated('pyodide/pyodide.asm.js', 'text/javascript')).blob()));
  const plainFetch = globalThis.fetch;
  const packed = { 'pyodide.asm.wasm': 'application/wasm', 'python_stdlib.zip': 'application/zip' };
  globalThis.fetch = (url, options) => {
    const name = String(url).split('/').at(-1);
    return packed[name] ? inflated(`pyodide/${name}`, packed[name]) : plainFetch(url, options);
  };
  python = await loadPyodide({
    indexURL: './pyodide/',
    stdout: (text) => postMessage({ kind: 'out', text }),
    stderr: (text) => postMessage({ kind: 'out', text }),
    env: {
      HOME: '/home', LANG: 'C.UTF-8', PYTHONHASHSEED: '0', PYTHONDONTWRITEBYTECODE: '1', ROS_DISTRO: 'jazzy',
      ROS_AUTOMATIC_DISCOVERY_RANGE: 'OFF', _ROS_WHEELS_BOOTSTRAP_COMPLETE: '1',
    },
  });
  globalThis.fetch = plainFetch;
  for (const pack of await packs) python.unpackArchive(pack, 'gztar', { extractDir: '/course' });
  [FOLDER, RECORDINGS].forEach((folder) => python.FS.mkdirTree(folder));
  say('Starting rclpy, the robot and the judge …');
  globalThis.reached = (seconds) => postMessage({ kind: 'reached', seconds });
  python.runPython(`
import sys
sys.path[:0] = ["/course", "/course/workspace/stand_ins"]
from workspace import runtime
from js import reached
page = runtime.warm("${RECORDINGS}", reached)
`);
  const page = python.globals.get('page');
  for (const name of ['trial', 'judge', 'replay']) calls[name] = page[name];
  image = python._module.HEAPU8.slice();
}

function restore() {
  const memory = python._module.HEAPU8;
  memory.set(image);
  memory.fill(0, image.length);
}

function write(files) {
  for (const old of python.FS.readdir(FOLDER)) if (!old.startsWith('.')) python.FS.unlink(`${FOLDER}/${old}`);
  for (const [name, text] of Object.entries(files)) python.FS.writeFile(`${FOLDER}/${name}`, text);
}

onmessage = async ({ data: { call, order, files } }) => {
  try {
    if (call === 'load') await load();
    else {
      if (files) write(files);
      restore();
    }
    const answer = call === 'load' ? '' : calls[call](JSON.stringify(order));
    postMessage({ kind: 'answer', answer, memory: python._module.HEAPU8.length });
  } catch (error) {
    postMessage({ kind: 'error', text: String(error && error.message ? error.message : error).slice(-4000) });
  }
};

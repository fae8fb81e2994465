// Run compile.py in Pyodide's own Python: node compile.mjs PYODIDE FOLDER PLACE KEEP LEVEL
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const [pyodide, folder, ...rest] = process.argv.slice(2);
const { loadPyodide } = await import(pathToFileURL(path.join(pyodide, 'pyodide.mjs')));
const python = await loadPyodide({ indexURL: `${pyodide}/` });
python.FS.mkdirTree('/stage');
python.FS.mount(python.FS.filesystems.NODEFS, { root: folder }, '/stage');
python.globals.set('words', python.toPy(['compile.py', '/stage', ...rest]));
python.runPython('import sys; sys.argv = words');
python.runPython(fs.readFileSync(path.join(path.dirname(fileURLToPath(import.meta.url)), 'compile.py'), 'utf8'));

// The editor, bundled by esbuild. Tab leaves it, as a keyboard user expects; Enter keeps the indent.
import { basicSetup } from 'codemirror';
import { python, pythonLanguage } from '@codemirror/lang-python';
import { indentUnit, syntaxHighlighting } from '@codemirror/language';
import { lintGutter, setDiagnostics } from '@codemirror/lint';
import { EditorView, keymap } from '@codemirror/view';
import { classHighlighter } from '@lezer/highlight';

/** Offer words after a dot; each has a value: what it belongs to. */
function afterDots(words) {
  const options = Object.entries(words).map(([label, detail]) => ({ label, detail, type: detail === 'Node' ? 'method' : 'property' }));
  return (context) => {
    const found = context.matchBefore(/\.\w*/);
    return found && { from: found.from + 1, options, validFor: /^\w*$/ };
  };
}

/** Go to the end of the line, not of what the window shows of it. */
function toEnd(view) {
  view.dispatch({ selection: { anchor: view.state.doc.lineAt(view.state.selection.main.head).to }, scrollIntoView: true });
  return true;
}

/** Return an editor: its text, and marks on lines. `keys` are shortcuts, by CodeMirror's names. */
export function makeEditor({ parent, text, label, onChange, keys, words }) {
  const view = new EditorView({
    doc: text,
    parent,
    extensions: [
      keymap.of([{ key: 'End', run: toEnd }]),
      keymap.of(Object.entries(keys).map(([key, act]) => ({ key, run: () => { act(); return true; } }))),
      basicSetup,
      python(),
      pythonLanguage.data.of({ autocomplete: afterDots(words) }),
      lintGutter(),
      EditorView.lineWrapping,
      indentUnit.of('    '),
      syntaxHighlighting(classHighlighter),
      EditorView.contentAttributes.of({ 'aria-label': label, tabindex: '0' }),
      EditorView.updateListener.of((update) => { if (update.docChanged) onChange(); }),
    ],
  });
  return {
    get text() { return view.state.doc.toString(); },
    set text(value) {
      view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: value } });
    },
    mark(line, message) {
      if (!line || line > view.state.doc.lines) {
        view.dispatch(setDiagnostics(view.state, []));
        return;
      }
      const { from: start, to, text: code } = view.state.doc.line(line);
      const from = start + code.search(/\S|$/);
      view.dispatch(setDiagnostics(view.state, [{ from, to, severity: 'error', message }]));
      view.dispatch({ effects: EditorView.scrollIntoView(from, { y: 'center' }) });
    },
    focus() { view.focus(); },
  };
}

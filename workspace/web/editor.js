// The editor, bundled by esbuild. Tab leaves it, as a keyboard user expects; Enter keeps the indent.
// No completion changes a word that is finished: Enter takes only what was chosen after the last key that types.
import { autocompletion, completeFromList, ifNotIn, moveCompletionSelection, setSelectedCompletion } from '@codemirror/autocomplete';
import { basicSetup } from 'codemirror';
import { python, pythonLanguage } from '@codemirror/lang-python';
import { indentUnit, syntaxHighlighting } from '@codemirror/language';
import { forEachDiagnostic, lintGutter, setDiagnostics } from '@codemirror/lint';
import { EditorState, Prec } from '@codemirror/state';
import { EditorView, keymap } from '@codemirror/view';
import { classHighlighter } from '@lezer/highlight';

// Those that lang-python has no snippet of
const KEYWORDS = ('and as assert async await break case continue del elif else except finally global in is lambda match '
  + 'nonlocal not or pass raise return self with yield').split(' ').map((label) => ({ label, type: 'keyword' }));
const keywords = ifNotIn(['String', 'FormatString', 'Comment', 'PropertyName'], completeFromList(KEYWORDS));

/** A choice is of the word as it stood: more typing drops it. */
const choose = [
  EditorState.transactionExtender.of((transaction) => (transaction.docChanged ? { effects: setSelectedCompletion(-1) } : null)),
  Prec.highest(keymap.of([{ key: 'Ctrl-Space', run: moveCompletionSelection(true) }])), // before the list's own: it opens it
  autocompletion({ selectOnOpen: false }),
];

/** Offer words after a dot; each has a value: what it belongs to. */
function afterDots(words) {
  const options = Object.entries(words).map(([label, detail]) => ({ label, detail, type: detail === 'Node' ? 'method' : 'property' }));
  return ifNotIn(['String', 'Comment'], (context) => {
    const found = context.matchBefore(/\.\w*/);
    return found && { from: found.from + 1, options, validFor: /^\w*$/ };
  });
}

/** Go to the end of the line, not of what the window shows of it. */
function toEnd(view) {
  view.dispatch({ selection: { anchor: view.state.doc.lineAt(view.state.selection.main.head).to }, scrollIntoView: true });
  return true;
}

/** Return an editor: its text, and marks on lines. */
export function makeEditor({ parent, text, label, onChange, words }) {
  const view = new EditorView({
    doc: text,
    parent,
    extensions: [
      keymap.of([{ key: 'End', run: toEnd }]),
      choose,
      basicSetup,
      python(),
      [afterDots(words), keywords].map((autocomplete) => pythonLanguage.data.of({ autocomplete })),
      pythonLanguage.data.of({ closeBrackets: { brackets: ['(', '[', '{'] } }), // quotes: a docstring's end would get two more
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
    mark(line, message, severity, moves) { // an "info" leaves what is wrong marked
      const kept = [];
      if (severity === 'info') forEachDiagnostic(view.state, (each, from, to) => kept.push({ ...each, from, to }));
      const wrong = kept.filter((each) => each.severity !== 'info');
      if (!line || line > view.state.doc.lines) {
        view.dispatch(setDiagnostics(view.state, wrong));
        return;
      }
      const { from: start, to, text: code } = view.state.doc.line(line);
      const from = start + code.search(/\S|$/);
      view.dispatch(setDiagnostics(view.state, [...wrong, { from, to, severity, message }]));
      const wants = moves && severity === 'error' ? { selection: { anchor: from } } : {}; // a look elsewhere leaves the cursor
      view.dispatch({ ...wants, effects: EditorView.scrollIntoView(from, { y: 'center' }) });
    },
    focus() { view.focus(); },
  };
}

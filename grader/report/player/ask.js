// The text by which a student asks a person to look again. The page has no server to send it to.

const REQUEST = 'request.txt';

/** A form whose text is copied or saved; `asked` says whose work in which exercise it is about. */
function buildAsk(asked, checks) {
  if (!asked || !text(asked.student)) return null;
  const core = checks.filter(isCore).map((check) => [text(check.id), check]);
  const label = (name, field) => el('label', { class: 'ask-field' }, el('span', {}, name), field);
  const check = el('select', {}, el('option', { value: '' }, 'none in particular'),
    core.map(([id]) => el('option', { value: id }, id)));
  const moment = el('input', { type: 'number', min: '0', step: 'any' });
  const words = el('textarea', { rows: '3', maxlength: '2000', dir: 'auto' });
  const made = el('textarea', { rows: '7', readonly: true, class: 'ask-text' });
  const said = el('p', { class: 'quiet', role: 'status' });
  const one = (value) => value.split(/\s+/).join(' ').trim();
  const write = () => {
    made.value = [`Student: ${text(asked.student)}`, `Exercise: ${text(asked.exercise)}`,
      `Check: ${check.value}`, `Moment: ${moment.value && `${moment.value} s`}`,
      `Please look at: ${one(words.value)}`, ''].join('\n');
  };
  const choose = () => {
    const found = core.find(([id]) => id === check.value);
    moment.value = found && Number.isFinite(found[1].time) ? String(found[1].time) : '';
    write();
  };
  const copy = async () => {
    made.select();
    try {
      await navigator.clipboard.writeText(made.value);
      said.textContent = 'Copied.';
    } catch { // in a frame, say
      said.textContent = 'The text is selected: copy it.';
    }
  };
  const save = () => el('a', { href: `data:text/plain;charset=utf-8,${encodeURIComponent(made.value)}`,
    download: REQUEST }).click();
  const button = (name, onclick) => el('button', { type: 'button', class: 'jump', onclick }, name);
  check.addEventListener('change', choose);
  for (const field of [moment, words]) field.addEventListener('input', write);
  write();
  return el('section', { class: 'ask', 'aria-label': 'Ask a person' }, el('details', {}, el('summary', {}, 'Ask a person to look again'),
    el('p', { class: 'quiet' }, 'Say in a sentence or two what should be looked at, and send the text to your '
      + 'instructor: as a mail, or as a file. Nothing is sent from here.'),
    label('Check', check), label('Moment in the run, in seconds', moment), label('What is wrong', words),
    label('Your text', made), el('div', { class: 'jumps' }, button('Copy', copy), button('Save as a file', save)), said));
}

// What a page does: questions, replays, wrong lines, progress, copying, printing. No network.
(() => {
  const STORE = 'bridging-python-agents';
  const article = document.querySelector('article');
  const all = (selector, within = article) => [...within.querySelectorAll(selector)];
  const make = (tag, settings = {}, ...children) => {
    const element = Object.assign(document.createElement(tag), settings);
    element.append(...children);
    return element;
  };
  const button = (label, className, onclick) => make('button', { type: 'button', className, onclick }, label);

  // --- progress, on this machine only --------------------------------------------------------

  const root = document.documentElement.dataset.content_root || './';
  const here = decodeURI(location.pathname).split('/').slice(-1 - (root.match(/\.\./g) || []).length).join('/');
  const read = () => {
    try { return JSON.parse(localStorage.getItem(STORE)) || {}; } catch { return {}; }
  };
  const write = (progress) => {
    try { localStorage.setItem(STORE, JSON.stringify(progress)); } catch { /* a private window */ }
    showProgress();
  };
  const remember = (change) => {
    const progress = read();
    progress[here] = { ...progress[here], ...change };
    write(progress);
  };
  const mine = () => read()[here] || {};

  function showProgress() {
    const progress = read();
    for (const link of all('.sidebar-tree a.internal, article table a.internal', document)) {
      const page = Object.keys(progress).find((name) => new URL(root + name, location.href).pathname === link.pathname);
      const { right = [], of = 0, done } = (!link.hash && progress[page]) || {};
      link.classList.toggle('is-done', Boolean(done || (of && right.length >= of)));
    }
    const count = document.getElementById('progress');
    if (!count) return;
    const kept = Object.values(progress).reduce((sum, { right = [], done }) => sum + right.length + (done ? 1 : 0), 0);
    const forget = button('Forget it', 'quiet', () => write({}));
    count.replaceChildren(kept ? `Your progress: ${kept} answered on this machine. ` : 'Your progress stays on this machine.',
      ...(kept ? [forget] : []));
  }

  // --- questions -----------------------------------------------------------------------------

  const questions = all('.question');
  if (questions.length) remember({ of: questions.length });
  for (const [number, question] of questions.entries()) {
    const status = question.querySelector('.status');
    const said = question.querySelector('.said');
    said.hidden = true;
    const choose = (option, speak) => {
      const right = 'right' in option.dataset;
      const feedback = option.nextElementSibling;
      feedback.hidden = false;
      said.hidden = false;
      option.classList.add(right ? 'is-right' : 'is-wrong');
      option.setAttribute('aria-expanded', 'true');
      if (speak) status.textContent = `${right ? 'Right' : 'Not so'}. ${feedback.textContent.trim()}`;
      if (right && speak) remember({ right: [...new Set([...(mine().right || []), number])] });
    };
    for (const option of all('.option', question)) {
      option.nextElementSibling.hidden = true;
      option.setAttribute('aria-expanded', 'false');
      option.addEventListener('click', () => choose(option, true));
      if ('right' in option.dataset && (mine().right || []).includes(number)) choose(option, false);
    }
  }

  // --- answers in one's own words ------------------------------------------------------------

  for (const [number, place] of all('.own-answer').entries()) {
    const own = place.querySelector('textarea');
    const model = place.querySelector('details');
    const kept = mine().answers || {};
    own.value = kept[number] || '';
    const open = () => { if (model) model.hidden = own.value.trim().split(/\s+/).length < 8; };
    const hint = make('p', { className: 'hint' }, 'Write three to six sentences; then compare.');
    if (model) model.before(hint);
    own.addEventListener('input', () => {
      open();
      remember({ answers: { ...mine().answers, [number]: own.value } });
    });
    open();
  }

  // --- replays -------------------------------------------------------------------------------

  const frames = () => all('iframe');
  const tell = (frame) => frame.contentWindow?.postMessage({ theme: document.body.dataset.theme, fit: true }, '*');
  window.addEventListener('message', ({ data, source }) => {
    const frame = frames().find(({ contentWindow }) => contentWindow === source);
    if (!frame || !data || !Number.isFinite(data.height)) return;
    frame.style.height = `${Math.min(data.height, 2400)}px`;
    frame.parentElement.classList.add('is-loaded');
  });
  const follow = (frame) => {
    frame.addEventListener('load', () => tell(frame));
    tell(frame); // it may have loaded already
  };
  frames().forEach(follow);
  new MutationObserver(() => frames().forEach(tell))
    .observe(document.body, { attributes: true, attributeFilter: ['data-theme'] });

  for (const link of all('a.watch')) {
    const title = `Replay: ${link.closest('figure').querySelector('figcaption').textContent.trim().slice(0, 120)}`;
    const figure = link.closest('figure');
    const show = (hash) => {
      const frame = make('iframe', { title, src: `${link.href}#${hash}` });
      const whole = make('a', { href: link.href, className: 'whole' }, 'Plot, log and keys: open it on its own page');
      play.replaceWith(frame);
      figure.append(whole);
      follow(frame);
    };
    const play = button('Watch it drive', 'watch', () => show('small&play'));
    link.replaceWith(play);
    if ('plays' in link.dataset) show('small&play&loop');
  }

  // --- the wrong line of a pitfall -----------------------------------------------------------

  for (const form of all('form.challenge')) {
    const wrong = form.dataset.lines.split(',').flatMap((part) => {
      const [from, to = from] = part.split('-').map(Number);
      return Array.from({ length: to - from + 1 }, (_, i) => from + i);
    });
    const listing = all('.highlight-python')[0];
    const [line] = form.elements;
    line.max = listing.querySelectorAll('.linenos').length;
    const later = [];
    for (let place = form; place && place !== article; place = place.parentElement) {
      for (let next = place.nextElementSibling; next; next = next.nextElementSibling) later.push(next);
    }
    const solve = (guess) => {
      form.classList.add('is-solved');
      document.body.classList.remove('has-challenge');
      later.forEach((part) => { part.hidden = false; });
      const where = `line${wrong.length > 1 ? 's' : ''} ${form.dataset.lines.replaceAll('-', ' – ').replaceAll(',', ', ')}`;
      const found = wrong.includes(guess);
      form.querySelector('.status').textContent = `${found ? 'Right' : guess ? 'Not that one' : 'Look'}: ${where}, marked now in the listing. Read on: why, and how to put it right.`;
      form.classList.toggle('is-right', found);
    };
    document.body.classList.add('has-challenge');
    later.forEach((part) => { part.hidden = true; });
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      solve(Number(line.value));
      remember({ done: true });
    });
    form.querySelector('.quiet').addEventListener('click', () => { solve(0); remember({ done: true }); });
    listing.addEventListener('click', ({ target }) => {
      const number = Number(target.closest('.linenos')?.textContent);
      if (number) line.value = number;
    });
    const target = location.hash && document.getElementById(location.hash.slice(1));
    if (target && later.some((part) => part.contains(target))) { solve(0); target.scrollIntoView(); }
    window.addEventListener('beforeprint', () => solve(0));
  }

  // --- copying, scrolling, folding, printing -------------------------------------------------

  for (const block of all('div.highlight-console, div.highlight-sh, div.highlight-python, div.highlight-default')) {
    const copy = button('Copy', 'copy', async () => {
      const lines = [...block.querySelector('pre').childNodes]
        .filter((node) => !(node.classList && (node.classList.contains('linenos') || node.classList.contains('gp'))));
      let text = lines.map((node) => {
        if (!node.querySelectorAll) return node.textContent;
        const line = node.cloneNode(true);
        line.querySelectorAll('.linenos, .gp').forEach((part) => part.remove());
        return line.textContent;
      }).join('');
      await navigator.clipboard.writeText(text.trimEnd());
      copy.textContent = 'Copied';
      setTimeout(() => { copy.textContent = 'Copy'; }, 1500);
    });
    copy.setAttribute('aria-label', 'Copy this block');
    block.append(copy);
  }

  // On a phone a row of a wide table is a card; roles, since a table that is no table loses its own
  for (const table of all('article table.docutils')) {
    const names = all('thead th', table).map((head) => head.textContent);
    if (names.length < 4 && table.scrollWidth <= article.clientWidth) continue;
    table.classList.add('is-wide');
    table.setAttribute('role', 'table');
    for (const row of all('tbody tr', table)) {
      row.setAttribute('role', 'row');
      [...row.cells].forEach((cell, i) => { cell.setAttribute('role', 'cell'); cell.dataset.name = names[i]; });
    }
  }

  const scrolls = new ResizeObserver((entries) => entries.forEach(({ target }) => {
    if (target.scrollWidth > target.clientWidth + 1) target.tabIndex = 0;
    else target.removeAttribute('tabindex');
  }));
  all(':is(.highlight pre, .table-wrapper, .drawing-frame, div.math)')
    .forEach((element) => scrolls.observe(element)); // also once its <details> opens

  const unfold = () => {
    let place = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    for (; place; place = place.parentElement) if (place.tagName === 'DETAILS') place.open = true;
  };
  window.addEventListener('hashchange', unfold);
  unfold();

  // On paper all is open but the answers: those of questions and guesses stand on a last page
  let turned = [];
  window.addEventListener('beforeprint', () => {
    turned = all('details:not([open], .model-answer, .look), details.look[open]');
    turned.forEach((details) => { details.open = !details.open; });
    const asked = all('.ask, .look > summary');
    if (!asked.length) return;
    const answers = make('section', { className: 'answers' }, make('h2', {}, 'Answers'));
    for (const [number, ask] of asked.entries()) {
      ask.dataset.answer = number + 1;
      const right = ask.parentElement.querySelector('.option[data-right]');
      const told = right ? [`${right.textContent}. `, ...right.nextElementSibling.childNodes] : [...ask.parentElement.childNodes].slice(1);
      answers.append(make('div', {}, make('strong', {}, `${number + 1} `), ...told.map((part) => part.cloneNode?.(true) ?? part)));
    }
    article.append(answers);
  });
  window.addEventListener('afterprint', () => {
    turned.forEach((details) => { details.open = !details.open; });
    article.querySelector('.answers')?.remove();
  });
  showProgress();
})();

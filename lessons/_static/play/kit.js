// Figures to play with: a law of settings, drawn, said in a sentence, and told in a table.
// Each figure calls play.add(name, {controls, presets, compute, draw, verdict, table, size}).
window.play = (() => {
  const figures = {};
  const SVG = 'http://www.w3.org/2000/svg';

  const element = (tag, attributes = {}, ...children) => {
    const made = Object.assign(document.createElement(tag), attributes);
    made.append(...children);
    return made;
  };

  /** Draw into an SVG: shape('rect', {x: 1, class: 'fill-accent'}), shape('text', {…}, 'words'). */
  const pen = (svg) => (tag, attributes = {}, text = '') => {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    svg.append(made);
    return made;
  };

  function control(name, { label, options, show = String, max, ...range }, settings, change) {
    const output = element('output');
    const input = options
      ? element('select', {}, ...options.map((text, i) => element('option', { value: i }, text)))
      : element('input', { type: 'range', ...range });
    const update = () => {
      if (max !== undefined) input.max = typeof max === 'function' ? max(settings) : max;
      input.value = settings[name];
      if (!options) {
        output.textContent = show(settings[name]);
        input.setAttribute('aria-valuetext', show(settings[name]));
      }
    };
    input.addEventListener('input', () => {
      settings[name] = Number(input.value);
      change();
    });
    return { update, element: element('label', {}, element('span', {}, `${label} `, output), input) };
  }

  function table({ head, rows }) {
    const cells = (tag, row) => row.map((text) => element(tag, {}, String(text)));
    return element('table', {}, element('thead', {}, element('tr', {}, ...cells('th', head))),
      element('tbody', {}, ...rows.map((row) => element('tr', {}, ...cells('td', row)))));
  }

  function mount(place, figure) {
    const [width, height] = figure.size;
    const svg = document.createElementNS(SVG, 'svg');
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    svg.setAttribute('role', 'img');
    const verdict = element('p', { className: 'verdict' });
    verdict.setAttribute('role', 'status');
    const numbers = element('div', { className: 'table-wrapper' });
    const settings = { ...figure.start };
    const change = () => {
      controls.forEach(({ update }) => update());
      const result = figure.compute(settings);
      svg.replaceChildren();
      figure.draw(pen(svg), settings, result);
      const { text, good } = figure.verdict(settings, result);
      svg.setAttribute('aria-label', `${figure.title}. The sentence below says what it shows, the table has its numbers.`);
      verdict.textContent = text;
      verdict.className = `verdict ${good === undefined ? '' : good ? 'is-good' : 'is-bad'}`;
      numbers.replaceChildren(table(figure.table(settings, result)));
    };
    const controls = Object.entries(figure.controls)
      .map(([name, made]) => control(name, made, settings, change));
    const presets = Object.entries(figure.presets || {}).map(([label, values]) => {
      const press = () => { Object.assign(settings, values); change(); };
      return element('button', { type: 'button', onclick: press }, label);
    });
    new ResizeObserver(() => { // words stay readable where the drawing is small
      svg.style.fontSize = `${12 * Math.min(Math.max(width / svg.clientWidth, 1), 1.6)}px`;
    }).observe(svg);
    place.prepend(element('div', { className: 'presets' }, ...presets), svg,
      element('p', { className: 'hint' }, figure.legend),
      element('div', { className: 'controls' }, ...controls.map((made) => made.element)), verdict,
      element('details', {}, element('summary', {}, 'The numbers'), numbers));
    change();
  }

  const ms = (value) => `${value} ms`;
  const seconds = (value) => `${(value / 1000).toFixed(2)} s`;
  return {
    ms,
    seconds,
    compute: (name, settings) => figures[name].compute({ ...figures[name].start, ...settings }),
    add(name, figure) {
      figures[name] = figure;
      document.querySelectorAll(`[data-play="${name}"]`).forEach((place) => mount(place, figure));
    },
  };
})();

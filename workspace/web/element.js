// Elements of a page.

/** Return an element: `on…` are listeners, other properties attributes; null children are left out. */
export function el(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== ''));
  return element;
}

/** A moment of the replay [s], which a slider or a number chooses: `go` is told which; Enter has `act` called. */
export class Moment {
  constructor(label, go, act = () => {}) {
    const choose = ({ target }) => { if (this.isChosen(target)) go(target.valueAsNumber); };
    const settle = () => {
      if (!this.isChosen(this.number)) this.number.value = Math.min(Math.max(this.number.value, 0), this.end).toFixed(2);
      go(this.number.valueAsNumber);
    };
    this.slider = el('input', { type: 'range', min: 0, step: 0.1, 'aria-label': `Moment ${label} [s]`, oninput: choose });
    this.number = el('input', { type: 'number', min: 0, step: 0.01, 'aria-label': `Time ${label} [s]`, oninput: choose, onchange: settle,
      onkeydown: ({ key }) => { if (key === 'Enter') [settle, act].forEach((each) => each()); } });
    this.element = el('div', { class: 'ws-moment' }, 'At [s]', this.number, this.slider);
  }

  isChosen(input) { return input.validity.valid && input.value !== ''; }

  /** What is being typed, until the field is left. */
  get typed() { return this.number.matches(':focus') && this.isChosen(this.number) ? this.number.valueAsNumber : null; }

  get end() { return Number(this.slider.max); }

  set end(duration) { this.slider.max = this.number.max = duration; }

  /** Show where the replay stands, unless somebody is choosing. */
  set at(moment) {
    if (!this.slider.matches(':active')) this.slider.value = moment;
    if (!this.number.matches(':focus')) this.number.value = moment.toFixed(2);
  }
}

// mountPlayer: one player in one element. Holds the state; the parts only show it.

const LEAD = 1; // [s] a jump to a moment starts before it
const NEAR_MOMENT = 1.2; // [s] after a moment its annotation goes

class Player {
  constructor(root, payload) {
    this.replays = toArray(payload && payload.replays).map(toReplay);
    this.runIndex = 0;
    this.moment = null;
    this.ontime = () => {};
    this.playback = new Playback(() => this.update());
    this.parts = buildPlayer(this.actions(), this.replays.length);
    this.world = new WorldView(this.parts.stage.canvas, {
      onhint: () => this.showHint(),
      onfree: (follow) => this.parts.stage.follow.setAttribute('aria-pressed', String(follow)),
    });
    this.plot = new Plot(this.parts.plot.canvas, (t) => this.seek(t));
    root.replaceChildren(this.parts.element);
    this.fillRuns();
    this.selectRun(0);
    this.listen();
  }

  get replay() {
    return this.replays[this.runIndex];
  }

  actions() {
    return {
      chooseRun: (event) => this.selectRun(Number(event.target.value)),
      chooseRate: (event) => this.playback.setRate(Number(event.target.value)),
      toggle: () => this.playback.toggle(),
      seek: (t) => this.seek(t),
      stepBack: () => this.step(-1),
      stepForward: () => this.step(1),
      previousMoment: () => this.neighbourMoment(-1),
      nextMoment: () => this.neighbourMoment(1),
      showMoment: (moment) => this.jumpTo(this.runIndex, this.replay.moments.indexOf(moment)),
      showNextOf: (group) => this.jumpTo(this.runIndex, this.replay.moments.indexOf(
        group[(group.indexOf(this.moment) + 1) % group.length])),
      zoomIn: () => this.zoom(ZOOM_STEP),
      zoomOut: () => this.zoom(1 / ZOOM_STEP),
      fit: () => { this.world.fit(); this.draw(); },
      toggleFollow: () => { this.world.setFollow(!this.world.follow); this.draw(); },
      toggleLidar: () => this.toggleLidar(),
      plotLinear: () => this.setAngular(false),
      plotAngular: () => this.setAngular(true),
      help: () => this.parts.help.showModal(),
    };
  }

  // --- runs ---------------------------------------------------------------------------------

  fillRuns() {
    replaceChildren(this.parts.head.select, this.replays.map((replay, i) => {
      const failures = replay.moments.length ? ` \u2014 ${plural(replay.moments.length, 'failing moment')}` : '';
      return el('option', { value: i }, replay.title.slice(0, 120) + failures);
    }));
  }

  selectRun(index) {
    this.runIndex = clamp(Math.floor(index) || 0, 0, this.replays.length - 1);
    const { replay, parts } = this;
    this.moment = null;
    this.playback.reset(replay.duration);
    parts.head.select.value = String(this.runIndex);
    parts.head.position.textContent = `${this.runIndex + 1} of ${this.replays.length}`;
    replaceChildren(parts.head.title, replay.title);
    replaceChildren(parts.head.description, replay.description);
    parts.head.description.hidden = !replay.description;
    const { kind, text: told } = replay.outcome;
    parts.head.outcome.hidden = !kind;
    parts.head.outcome.className = `run-outcome ${kind === 'completed' ? '' : 'is-bad'}`;
    replaceChildren(parts.head.outcome, kind === 'completed' ? 'Ran to its end' : told || kind.replaceAll('_', ' '));
    replaceChildren(parts.head.traceback, replay.outcome.detail);
    parts.head.detail.hidden = !replay.outcome.detail;
    parts.stage.canvas.setAttribute('aria-label',
      `Map of the run ${replay.title.slice(0, 200)}. The run is described in words below.`);
    replaceChildren(parts.stage.legend,
      replay.ghosts.map(({ name }, i) => el('span', { class: `ghost is-${i}` }, name)),
      el('span', { class: 'speeds' }, el('span', {}, '0'), el('i', {}), el('span', {}, `${fixed(replay.maxSpeed)} m/s`)));
    parts.transport.moments.forEach((button) => { button.disabled = !replay.moments.length; });
    for (const part of [parts.timeline, parts.log, this.world, this.plot]) part.setReplay(replay);
    this.showGraph();
    renderAccount(parts.account, replay, (event) => (
      event.moment ? this.actions().showMoment(event.moment) : this.seek(event.t)));
    this.update();
  }

  /** Show the run's graph, as the page brought it: above the map if it has faults or several nodes. */
  showGraph() {
    const drawn = document.getElementById('graphs')?.content.children[this.runIndex]?.firstElementChild;
    this.graph?.remove();
    this.graph = drawn && document.importNode(drawn, true);
    if (!drawn) return;
    const isFirst = drawn.matches('.is-first');
    const { element } = this.parts;
    if (isFirst && !this.replays[1] && element.clientWidth > 560 && !element.closest('.is-embedded')) this.graph.open = true;
    (isFirst ? this.parts.head.element : this.parts.side).append(this.graph);
  }

  // --- time ---------------------------------------------------------------------------------

  seek(t) {
    this.playback.seek(t);
    this.announce();
  }

  step(direction) {
    this.playback.pause();
    const times = stepTimes(this.replay);
    const here = indexAt(times, this.playback.time);
    const exact = here >= 0 && Math.abs(times[here] - this.playback.time) < 1e-6;
    const next = direction > 0 ? here + 1 : here - (exact ? 1 : 0);
    const beyond = direction > 0 ? this.replay.duration : 0;
    this.seek(next >= 0 && next < times.length ? times[next] : beyond);
  }

  /** Show a failing moment: play the second before it and pause there (or go there at once). */
  jumpTo(runIndex, momentIndex) {
    if (runIndex !== this.runIndex) this.selectRun(runIndex);
    const moment = this.replay.moments[momentIndex];
    if (!moment) return;
    this.playback.pause();
    this.moment = moment;
    const calm = calmMotion() || this.playback.duration <= 0;
    this.playback.seek(calm ? moment.t : moment.t - LEAD);
    if (!calm) this.playback.playUntil(moment.t);
    this.update();
    this.announce();
  }

  /** Stand where there is most to see; `lead`: a moment is led up to. */
  open(opening, lead) {
    if (!opening) return;
    const { run, moment, t } = opening;
    if (run !== this.runIndex) this.selectRun(run);
    if (moment !== undefined && lead) this.jumpTo(run, moment);
    else this.playback.seek(moment === undefined ? t : this.replay.moments[moment].t);
  }

  /** The keyboard goes where the eye goes; from here Space plays and the arrows step. */
  focus() {
    this.parts.transport.play.focus({ preventScroll: true });
  }

  neighbourMoment(direction) {
    const { moments } = this.replay;
    const now = this.playback.playing && this.moment ? this.moment.t : this.playback.time;
    const from = moments.indexOf(this.moment);
    const ahead = moments.findIndex((m) => m.t > now + 1e-6);
    const behind = moments.findLastIndex((m) => m.t < now - 1e-6);
    const next = from >= 0 ? from + direction : direction > 0 ? ahead : behind;
    if (next >= 0 && next < moments.length) this.jumpTo(this.runIndex, next);
  }

  // --- showing ------------------------------------------------------------------------------

  update() {
    const { parts, playback } = this;
    const { time, playing } = playback;
    this.chooseMoment(time);
    setIcon(parts.transport.play, playing ? 'pause' : 'play', playing ? 'Pause (Space)' : 'Play (Space)');
    parts.transport.rate.value = String(playback.rate);
    parts.transport.clock.textContent = `${fixed(time)} / ${seconds(playback.duration)}`;
    parts.timeline.update(time, playing);
    parts.log.update(time);
    this.showReadout(stateAt(this.replay, time));
    this.showAnnotation();
    if (this.wasPlaying && !playing) this.announce();
    this.wasPlaying = playing;
    this.draw();
    this.ontime(time);
  }

  /** The moment whose annotation shows: the one jumped to or just passed. */
  chooseMoment(time) {
    const near = (m) => time >= m.t - 1e-6 && time <= m.t + NEAR_MOMENT;
    const leading = this.playback.stopAt !== null;
    if (this.moment && (leading || (time >= this.moment.t - LEAD - 1e-6 && time <= this.moment.t + NEAR_MOMENT))) return;
    this.moment = this.replay.moments.findLast(near) || null;
  }

  draw() {
    this.world.draw(this.playback.time, this.moment);
    this.plot.draw(this.playback.time);
  }

  showReadout({ v, w, commandV, commandW, clearance, touching }) {
    const { values } = this.parts.readout;
    values.speed.textContent = withUnit(v, 'm/s').replace('unknown', '\u2013');
    values.turn.textContent = withUnit(w, 'rad/s').replace('unknown', '\u2013');
    const command = this.plot.angular ? withUnit(commandW, 'rad/s') : withUnit(commandV, 'm/s');
    values.command.textContent = command.replace('unknown', '\u2013');
    values.clearance.textContent = touching ? 'contact'
      : clearance >= 10 ? 'over 10\u00a0m' : withUnit(clearance, 'm').replace('unknown', '\u2013');
    values.clearance.classList.toggle('is-bad', touching);
  }

  showAnnotation() {
    const { annotation } = this.parts.stage;
    if (this.shownMoment === this.moment) return;
    this.shownMoment = this.moment;
    annotation.hidden = !this.moment;
    if (!this.moment) return;
    const pose = poseAt(this.replay.truth, this.moment.t);
    const [, y] = pose ? this.world.camera.toScreen(pose.x, pose.y) : [0, Infinity];
    annotation.classList.toggle('is-low', y < 0.45 * this.world.camera.height);
    const { t, title, expected, actual, message } = this.moment;
    const row = (name, value) => (value
      ? [el('dt', {}, name), el('dd', { dir: 'auto' }, unbroken(value.slice(0, 600)))] : []);
    replaceChildren(annotation,
      el('p', { class: 'annotation-title' }, icon('fail'), el('strong', { dir: 'auto' }, title.slice(0, 300)),
        el('span', { class: 'annotation-time' }, seconds(t))),
      expected || actual ? el('dl', {}, row('expected', expected), row('actual', actual))
        : el('p', { dir: 'auto' }, unbroken(message.slice(0, 600))));
    annotation.tabIndex = annotation.scrollHeight > annotation.clientHeight ? 0 : -1; // to scroll it
  }

  /** Tell screen readers where the replay stands, while it does not play. */
  announce() {
    if (this.playback.playing) return;
    const { pose, v, clearance, touching } = stateAt(this.replay, this.playback.time);
    const gap = touching ? 'in contact' : `clearance ${withUnit(clearance, 'm')}`;
    const others = this.replay.ghosts.map(({ name, pose: series }) => [name, poseAt(series, this.playback.time)])
      .map(([name, there]) => (there ? `; ${name} at ${place(there)}` : '')).join('');
    const where = (pose ? `robot at ${place(pose)}, ${withUnit(v, 'm/s')}, ${gap}` : 'position unknown') + others;
    const failed = this.moment
      ? ` Check failed: ${this.moment.title} Expected ${this.moment.expected}, actual ${this.moment.actual}.` : '';
    this.parts.status.textContent = plainText(`${seconds(this.playback.time)}: ${where}.${failed}`).slice(0, 1000);
  }

  showHint() {
    const { hint } = this.parts.stage;
    hint.hidden = false;
    clearTimeout(this.hintTimer);
    this.hintTimer = setTimeout(() => { hint.hidden = true; }, 1600);
  }

  zoom(factor) {
    this.world.zoom(factor);
    this.draw();
  }

  toggleLidar() {
    this.world.showLidar = !this.world.showLidar;
    this.parts.stage.lidar.setAttribute('aria-pressed', String(this.world.showLidar));
    this.draw();
  }

  setAngular(angular) {
    this.plot.setAngular(angular);
    this.parts.plot.linear.setAttribute('aria-pressed', String(!angular));
    this.parts.plot.angular.setAttribute('aria-pressed', String(angular));
    this.update();
  }

  // --- events -------------------------------------------------------------------------------

  listen() {
    this.parts.element.addEventListener('redraw', () => this.draw());
    this.onKey = (event) => this.handleKey(event);
    document.addEventListener('keydown', this.onKey);
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(this.parts.stage.canvas);
    this.sizes.observe(this.parts.plot.canvas);
    this.dark = matchMedia('(prefers-color-scheme: dark)');
    this.onTheme = () => this.readTheme();
    this.dark.addEventListener('change', this.onTheme);
    document.addEventListener('themechange', this.onTheme);
    this.readTheme();
  }

  destroy() {
    this.playback.pause();
    document.removeEventListener('keydown', this.onKey);
    document.removeEventListener('themechange', this.onTheme);
    this.dark.removeEventListener('change', this.onTheme);
    this.sizes.disconnect();
    this.parts.element.remove();
  }

  resize() {
    this.world.resize();
    this.plot.resize();
    this.parts.timeline.resize();
    this.draw();
  }

  readTheme() {
    this.world.readTheme();
    this.plot.readTheme();
    this.draw();
  }

  handleKey(event) {
    const { target } = event;
    const elsewhere = target !== document.body && !this.parts.element.contains(target);
    if (elsewhere || event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (target.closest('input, select, textarea, dialog')) return;
    if (event.key === ' ' && target.closest('button, summary, a')) return; // it presses that
    const action = this.keyAction(event);
    if (!action) return;
    event.preventDefault();
    action();
  }

  keyAction({ key, shiftKey }) {
    const actions = this.actions();
    const byTime = (dt) => () => this.seek(this.playback.time + dt);
    return {
      ' ': actions.toggle,
      ArrowLeft: shiftKey ? byTime(-1) : actions.stepBack,
      ArrowRight: shiftKey ? byTime(1) : actions.stepForward,
      Home: () => this.seek(0),
      End: () => this.seek(this.replay.duration),
      '[': () => this.playback.changeRate(-1),
      ']': () => this.playback.changeRate(1),
      n: actions.nextMoment, N: actions.nextMoment,
      p: actions.previousMoment, P: actions.previousMoment,
      f: actions.toggleFollow, F: actions.toggleFollow,
      0: actions.fit, '+': actions.zoomIn, '=': actions.zoomIn, '-': actions.zoomOut,
      '?': actions.help,
    }[key];
  }
}

/** Show the replays of a payload in an element; returns what a page or a test may steer. */
function mountPlayer(root, payload) {
  if (!toArray(payload && payload.replays).length) {
    root.replaceChildren(el('p', { class: 'quiet' }, 'There is no run to replay.'));
    return null;
  }
  const player = new Player(root, payload);
  const { playback } = player;
  return {
    get time() { return playback.time; },
    get duration() { return playback.duration; },
    get playing() { return playback.playing; },
    get rate() { return playback.rate; },
    get run() { return player.runIndex; },
    get runs() { return player.replays.map(({ scenario, moments }) => ({ scenario, moments: moments.length })); },
    get moment() { return player.moment && { ...player.moment }; },
    get following() { return player.world.follow; },
    get view() { return { x: player.world.camera.x, y: player.world.camera.y, scale: player.world.camera.scale }; },
    get state() { return stateAt(player.replay, playback.time); },
    play: () => playback.play(),
    playAgain: (loop) => { playback.seek(0); playback.loop = loop; playback.play(); },
    pause: () => playback.pause(),
    seek: (t) => player.seek(t),
    step: (direction) => player.step(direction),
    advance: (dt) => playback.advance(dt),
    setRate: (rate) => playback.setRate(rate),
    selectRun: (index) => player.selectRun(index),
    jumpTo: (run, moment) => player.jumpTo(run, moment),
    open: (checks, lead = false, told = null) => player.open(openingOf(checks, player.replays, told), lead),
    focus: () => player.focus(),
    tell: (ontime, onplace) => { [player.ontime, player.world.onplace] = [ontime, onplace]; ontime(playback.time); },
    destroy: () => player.destroy(),
  };
}

window.mountPlayer = mountPlayer;

// The map: a canvas with a camera that the pointer and the keys can move.

const ZOOM_STEP = 1.3;
const CLICK = 4; // [pixels] a pointer that moves more than that is dragging the map

class WorldView {
  constructor(canvas, { onhint, onfree }) {
    this.canvas = canvas;
    this.camera = new Camera();
    this.replay = null;
    this.fitted = true; // the camera still shows everything, so it may fit again on a resize
    this.follow = false;
    this.showLidar = true;
    this.onhint = onhint;
    this.onfree = onfree;
    this.onplace = () => {}; // told where somebody clicked [m]
    this.pointers = new Map();
    this.listen();
  }

  setReplay(replay) {
    this.replay = replay;
    this.bounds = boundsOf(replay);
    this.fit();
  }

  readTheme() {
    this.colours = readColours(this.canvas.parentElement, WORLD_COLOURS);
  }

  resize() {
    Object.assign(this.camera, sizeCanvas(this.canvas));
    if (this.fitted && this.bounds) this.camera.fit(this.bounds);
  }

  fit() {
    this.fitted = true;
    this.setFollow(false);
    this.resize();
  }

  zoom(factor, px, py) {
    this.fitted = false;
    this.camera.zoom(factor, px, py);
  }

  pan(dx, dy) {
    this.fitted = false;
    this.setFollow(false);
    this.camera.pan(dx, dy);
  }

  setFollow(follow) {
    if (follow === this.follow) return;
    this.follow = follow;
    if (follow) this.fitted = false;
    this.onfree(follow);
  }

  draw(time, activeMoment) {
    if (!this.replay) return;
    if (!this.colours) this.readTheme();
    const { replay, camera } = this;
    const ctx = this.canvas.getContext('2d');
    const brush = { ctx, camera, colours: this.colours, calm: calmMotion() };
    const pose = this.follow ? poseAt(replay.truth, time) : null;
    if (pose) Object.assign(camera, { x: pose.x, y: pose.y });
    ctx.fillStyle = this.colours.map;
    ctx.fillRect(0, 0, camera.width, camera.height);
    drawGrid(brush);
    const scan = this.showLidar ? scanAt(brush, replay, time) : null;
    if (scan) drawFan(brush, scan);
    drawWorld(brush, replay);
    if (scan) drawHits(brush, scan, replay.radius);
    drawTrail(brush, replay, time);
    drawGoals(brush, replay, time);
    drawCarts(brush, replay, time);
    drawContacts(brush, replay, time);
    drawMoments(brush, replay, activeMoment);
    drawRobot(brush, replay, time);
    drawGhosts(brush, replay, time);
    drawScaleBar(brush);
  }

  // --- pointer ------------------------------------------------------------------------------

  listen() {
    const { canvas } = this;
    canvas.addEventListener('wheel', (event) => this.onWheel(event), { passive: false });
    canvas.addEventListener('pointerdown', (event) => this.onDown(event));
    canvas.addEventListener('pointermove', (event) => this.onMove(event));
    canvas.addEventListener('click', (event) => {
      if (!this.moved) this.onplace(this.camera.toWorld(event.offsetX, event.offsetY));
    });
    for (const name of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
  }

  /** The wheel zooms where the map has been clicked or Ctrl is held; else the page scrolls on. */
  onWheel(event) {
    if (!event.ctrlKey && !event.metaKey && document.activeElement !== this.canvas) {
      this.onhint();
      return;
    }
    event.preventDefault();
    this.zoom(Math.exp(-clamp(event.deltaY, -120, 120) / 400), event.offsetX, event.offsetY);
    this.requestDraw();
  }

  onDown(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    [this.began, this.moved] = [[event.offsetX, event.offsetY], false];
  }

  onMove(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.offsetX, event.offsetY];
    this.moved ||= Math.hypot(now[0] - this.began[0], now[1] - this.began[1]) > CLICK;
    const other = [...this.pointers].find(([id]) => id !== event.pointerId);
    if (other) this.pinch(before, now, other[1]);
    else this.pan(now[0] - before[0], now[1] - before[1]);
    this.pointers.set(event.pointerId, now);
    this.requestDraw();
  }

  pinch(before, now, fixedPoint) {
    const spread = ([x, y]) => Math.hypot(x - fixedPoint[0], y - fixedPoint[1]) || 1;
    this.zoom(spread(now) / spread(before), ...fixedPoint);
  }

  requestDraw() {
    this.canvas.dispatchEvent(new CustomEvent('redraw', { bubbles: true }));
  }
}

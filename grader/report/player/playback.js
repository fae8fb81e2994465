// The clock of the player: where it stands, whether it runs, how fast, and where it stops by itself.

const RATES = [0.25, 0.5, 1, 2, 4, 8];
const LONGEST_FRAME = 0.1; // [s] a tab that was hidden goes on where it was

class Playback {
  constructor(onchange) {
    this.onchange = onchange;
    this.duration = 0;
    this.time = 0;
    this.rate = 1;
    this.playing = false;
    this.stopAt = null;
    this.loop = false;
    this.frame = 0;
  }

  reset(duration) {
    this.pause();
    this.duration = duration;
    this.time = 0;
  }

  seek(t) {
    this.stopAt = null;
    this.time = clamp(Number.isFinite(t) ? t : 0, 0, this.duration);
    this.onchange();
  }

  play() {
    if (this.playing || this.duration <= 0) return;
    if (this.time >= this.duration - 1e-6) this.time = 0;
    this.playing = true;
    let before = null;
    const tick = (now) => {
      if (!this.playing) return;
      if (before !== null) this.advance(Math.min((now - before) / 1000, LONGEST_FRAME) * this.rate);
      before = now;
      if (this.playing) this.frame = requestAnimationFrame(tick);
    };
    this.frame = requestAnimationFrame(tick);
    this.onchange();
  }

  /** Play up to t and pause exactly there. */
  playUntil(t) {
    this.play();
    this.stopAt = t;
  }

  pause() {
    cancelAnimationFrame(this.frame);
    this.stopAt = null;
    if (!this.playing) return;
    this.playing = false;
    this.onchange();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  /** Let scenario time pass; stops at stopAt and at the end. */
  advance(dt) {
    const end = this.stopAt === null ? this.duration : Math.min(this.stopAt, this.duration);
    this.time = Math.min(this.time + dt, end);
    if (this.time >= end && this.loop && this.stopAt === null) {
      this.time = 0;
    } else if (this.time >= end) {
      this.playing = false;
      this.stopAt = null;
    }
    this.onchange();
  }

  setRate(rate) {
    this.rate = RATES.includes(rate) ? rate : 1;
    this.onchange();
  }

  changeRate(steps) {
    const i = clamp(RATES.indexOf(this.rate) + steps, 0, RATES.length - 1);
    this.setRate(RATES[i]);
  }
}

// Python: workers that drive and judge, one call at a time each.

const HERE = new URL('.', import.meta.url);
export const PATIENCE = 10; // [s] without a word of the worker, after which the reader is asked

export class Stopped extends Error {}

/** A worker with a Python of its own: one call at a time. `onnews` hears what it says, `onsilence` that it says nothing. */
class Hand {
  constructor(manifest, { onnews, onsilence }) {
    this.manifest = manifest;
    this.onnews = onnews;
    this.onsilence = onsilence;
    this.worker = null;
    this.isWarm = false;
    this.doing = '';
  }

  /** Start a worker unless one is there, and wait until it is warm. */
  ready() {
    if (!this.worker) {
      this.warm = this.start();
      this.warm.then(() => { this.isWarm = true; }, () => this.end());
    }
    return this.warm;
  }

  start() {
    this.worker = new Worker(new URL(`worker.js?${this.manifest['worker.js'].sha256}`, HERE));
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => this.hear({ kind: 'error', text: event.message || 'the worker did not start' });
    return this.send({ call: 'load', manifest: this.manifest });
  }

  /** Call a method of workspace.runtime.Runtime in a fresh copy of the warm process; return what it says, and recordings. */
  async call(call, order, { files = {}, recordings = {} }) {
    await this.ready();
    [this.reached, this.where] = [0, order.scenario || (call === 'judge' ? 'the judgement' : 'the drive')];
    this.began = performance.now();
    this.watch();
    try {
      const { said, recordings: made } = await this.send({ call, order, files, recordings });
      return [call === 'replay' ? said : JSON.parse(said), made];
    } finally {
      clearTimeout(this.dog);
    }
  }

  send(message) {
    return new Promise((resolve, reject) => {
      this.waiting = { resolve, reject };
      this.worker.postMessage(message);
    });
  }

  hear(data) {
    if (data.kind === 'answer') {
      this.waiting.resolve(data);
      this.waiting = null;
    } else if (data.kind === 'error') this.end(new Error(data.text));
    else {
      if (data.kind === 'reached') {
        this.reached = data.seconds;
        this.watch();
      }
      this.onnews(this, data);
    }
  }

  watch() {
    clearTimeout(this.dog);
    this.dog = setTimeout(() => this.onsilence(this), PATIENCE * 1000);
  }

  end(why) {
    clearTimeout(this.dog);
    this.worker?.terminate();
    this.worker = null;
    this.isWarm = false;
    this.waiting?.reject(why);
    this.waiting = null;
  }
}

/** All workers: the one that is waited for, and a spare, where there is a processor and memory for it. */
export class Machine {
  constructor(manifest) {
    this.manifest = manifest;
    this.user = null; // the workspace that hears of what is done
    const listeners = { onnews: (hand, news) => this.user.hear(hand, news), onsilence: (hand) => this.user.ask(hand) };
    const memory = navigator.deviceMemory ?? (matchMedia('(pointer: fine)').matches ? 8 : 2); // [GB]
    const most = navigator.hardwareConcurrency > 1 && memory >= 4 ? 2 : 1;
    this.hands = Array.from({ length: most }, () => new Hand(manifest, listeners));
  }

  /** Serve a workspace; what another one was at is stopped. */
  serve(user) {
    if (this.user !== user) this.hands.filter((hand) => hand.isWarm && hand.waiting).forEach((hand) => hand.end(new Stopped()));
    this.user = user;
  }

  /** Return a warm hand; the others get ready meanwhile. */
  async ready() {
    this.first = this.hands.find((hand) => hand.isWarm) || this.hands.find((hand) => hand.worker) || this.hands[0];
    await this.first.ready();
    for (const hand of this.hands) hand.ready().catch(() => {}); // no memory for it: one will do
    return this.first;
  }

  async call(...call) { return (await this.ready()).call(...call); }

  /** Let every warm hand, and each that gets warm meanwhile, do something again and again while it returns true. */
  async together(act) {
    await this.ready();
    let [finish, isOver] = [null, false];
    const over = new Promise((resolve) => { finish = () => { isOver = true; resolve(); }; });
    try {
      await Promise.all(this.hands.map(async (hand) => {
        await Promise.race([hand.warm.catch(() => over), over]);
        while (!isOver && hand.isWarm && await act(hand)); // eslint-disable-line no-await-in-loop
        finish();
      }));
    } finally {
      finish(); // a hand that gets warm after another's error has nothing to do any more
    }
  }

  /** Let every Python start anew: one of them has broken. */
  renew() { this.hands.forEach((hand) => hand.end(new Stopped())); }

  /** Stop whatever runs; a spare stays. */
  stop() {
    const hands = this.hands.filter((hand) => hand.waiting && (hand.isWarm || hand === this.first));
    for (const hand of hands) hand.end(new Stopped());
  }
}

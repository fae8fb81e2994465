// What this browser can do: that is asked of it, never of its name.

const NEEDED = ['WebAssembly', 'Worker', 'DecompressionStream', 'HTMLDialogElement'];

/** What the workspace can't do without, and this browser hasn't. */
export const missing = NEEDED.filter((name) => !globalThis[name]);

/** Whether a stack can wait for a promise here (JSPI): threads, and several programs at a time, want it. */
export const hasStacks = 'Suspending' in (globalThis.WebAssembly ?? {});

/** Return whether a check of plan.json can be judged in this browser. */
export const isJudged = ({ scenarios, alone }) => scenarios.length > 0 && (hasStacks || alone);

/** Say what of an exercise runs here; its `points`, those that are judged `here`, and of these the ones `alone`, without stacks. */
export function runsHere({ points, here, alone }) {
  const installed = 'the installed course judges all of them';
  if (missing.length) return `Nothing of it runs here: this browser has no ${missing.join(', no ')}.`;
  if (!hasStacks && alone < here) {
    return `Needs JSPI (threads in a page), which this browser hasn’t: ${alone} of the ${points} points are judged here; ${installed}.`;
  }
  return here === points ? `Runs here: all ${points} points are judged.` : `Runs here: ${here} of the ${points} points are judged; ${installed}.`;
}

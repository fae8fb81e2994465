// What a later visit without a network needs.

const HERE = new URL('.', import.meta.url);
const CACHE = 'course-workspace'; // also in worker.js

/** Keep what this page is made of; worker.js keeps its own. Where the browser keeps nothing, it works without. */
export async function keepForLater(manifest, more) {
  const root = new URL('../../', HERE); // of the site
  await navigator.serviceWorker.register(new URL('offline.js', root));
  const store = await caches.open(CACHE);
  const hashes = Object.values(manifest).map(({ sha256 }) => `?${sha256}`);
  const isOld = ({ url }) => /\?[0-9a-f]{64}$/.test(url) && !hashes.some((hash) => url.endsWith(hash));
  await Promise.all((await store.keys()).filter(isOld).map((request) => store.delete(request)));
  const loaded = performance.getEntriesByType('resource').map(({ name }) => name).filter((name) => name.startsWith(root));
  const worker = new URL(`worker.js?${manifest['worker.js'].sha256}`, HERE).href;
  await Promise.all([...new Set([...more, worker, ...loaded])].map((name) => store.add(name).catch(() => {})));
  await navigator.serviceWorker.ready; // the page itself last: with it a visit needs no network
  await store.add(location.pathname);
}

/** Keep what is fetched once it is wanted; without https there is no store. */
export async function alsoKeep(...names) {
  const store = await globalThis.caches?.open(CACHE).catch(() => null);
  await store?.addAll(names).catch(() => {});
}

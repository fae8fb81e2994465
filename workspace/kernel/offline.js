// Ahead of JupyterLite's own: what is loaded is kept, and answers for a server that does not. The page hears of it (loading.js).
addEventListener('fetch', (event) => {
  const { request } = event;
  if (request.method !== 'GET' || /\/api\/(drive|stdin|service-worker)/.test(request.url)) return;
  event.stopImmediatePropagation();
  const tell = async (kind) => {
    for (const client of await clients.matchAll({ includeUncontrolled: true })) client.postMessage({ kind, address: request.url });
  };
  event.respondWith((async () => {
    const store = await caches.open('course-notebooks');
    try {
      const answer = await fetch(request);
      if (answer.ok) event.waitUntil(store.put(request, answer.clone()).catch(() => {}).then(() => tell('loaded')));
      return answer;
    } catch (error) {
      const kept = await store.match(request, { ignoreVary: true })
        || await store.match(request, { ignoreVary: true, ignoreSearch: true });
      event.waitUntil(tell(kept ? 'loaded' : 'missing'));
      if (kept) return kept;
      throw error;
    }
  })());
});

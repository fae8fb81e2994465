// Tells the replays light or dark, as the reader has chosen, and makes each frame as tall as its page.
(() => {
  const frames = [...document.querySelectorAll('.replay iframe')];
  const tell = (frame) => frame.contentWindow.postMessage({ theme: document.body.dataset.theme, fit: true }, '*');
  window.addEventListener('message', ({ data, source }) => {
    const frame = frames.find(({ contentWindow }) => contentWindow === source);
    if (frame && data && Number.isFinite(data.height)) frame.style.height = `${Math.min(data.height, 2400)}px`;
  });
  frames.forEach((frame) => {
    frame.addEventListener('load', () => tell(frame));
    tell(frame); // it may have loaded already
  });
  new MutationObserver(() => frames.forEach(tell))
    .observe(document.body, { attributes: true, attributeFilter: ['data-theme'] });
})();

// What scrolls sideways can be reached by keyboard; what is folded is printed, too.
(() => {
  const scrolls = new ResizeObserver((entries) => entries.forEach(({ target }) => {
    if (target.scrollWidth > target.clientWidth + 1) target.tabIndex = 0;
    else target.removeAttribute('tabindex');
  }));
  document.querySelectorAll('article :is(.highlight pre, .table-wrapper, .drawing-frame, div.math)')
    .forEach((element) => scrolls.observe(element)); // also once its <details> opens
  let folded = [];
  window.addEventListener('beforeprint', () => {
    folded = [...document.querySelectorAll('article details:not([open])')];
    folded.forEach((details) => { details.open = true; });
  });
  window.addEventListener('afterprint', () => folded.forEach((details) => { details.open = false; }));
})();

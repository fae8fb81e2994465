// Load the workspace where it can run: a page that was opened as a file may start no worker.
if (location.protocol !== 'file:') import(new URL('page.js', document.currentScript.src));

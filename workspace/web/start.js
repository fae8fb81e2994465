// Load the workspace where it can run: a page that was opened as a file may start no worker.
{
  const say = (text) => document.querySelectorAll('.workspace-words').forEach((place) => { place.textContent = text; });
  if (location.protocol === 'file:') {
    say('Opened as a file, the workspace can’t start: let a web server have the site’s folder, as python3 -m http.server there.');
  } else {
    import(new URL('page.js', document.currentScript.src))
      .catch((error) => say(`The workspace did not load (${error.message}). Reload the page.`));
  }
}

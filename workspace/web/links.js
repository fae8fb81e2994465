// Code in a link: browsers send what follows a # to no server.

const MOST = 2 ** 20; // [bytes] that a link may unpack to: a short one could fill the memory

/** Return a stream that throws where more than MOST would come out of it. */
function limited() {
  let left = MOST;
  return new TransformStream({
    transform(part, controller) {
      left -= part.length;
      if (left < 0) throw new RangeError(`more than ${MOST} bytes`);
      controller.enqueue(part);
    },
  });
}

const through = async (bytes, stream) => new Uint8Array(
  await new Response(new Blob([bytes]).stream().pipeThrough(stream).pipeThrough(limited())).arrayBuffer());

/** Return a text as it stands in a link. */
export async function packed(text) {
  const bytes = await through(new TextEncoder().encode(text), new CompressionStream('deflate'));
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join('')).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
}

/** Return the text of a link; it throws if anything is amiss. */
export async function unpacked(code) {
  const bytes = Uint8Array.from(atob(code.replaceAll('-', '+').replaceAll('_', '/')), (c) => c.charCodeAt(0));
  return new TextDecoder('utf-8', { fatal: true }).decode(await through(bytes, new DecompressionStream('deflate')));
}

/** Have what follows the # in the address bar. */
export function stand(hash) { history.replaceState(null, '', location.pathname + location.search + hash); }

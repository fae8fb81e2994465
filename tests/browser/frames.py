"""Pages and frames that hold a replay: look at them until something is so."""

from typing import Any

LIMIT = 60.0  # [s] for a server to start, a notebook to run: far more than they take


def wait_until(place: Any, condition: str) -> None:
    """Look at each frame; Playwright's own waiting needs eval, which the replays forbid."""
    place.evaluate(
        f"""() => new Promise((resolve, reject) => {{
          const end = performance.now() + {LIMIT * 1000};
          const look = () => {{
            if ({condition}) resolve();
            else if (performance.now() > end) reject(new Error('waited too long'));
            else requestAnimationFrame(look);
          }};
          look();
        }})"""
    )


def value(place: Any, expression: str) -> Any:
    """Return what the replay's player says."""
    return place.evaluate(f"window.replayPlayer.{expression}")


def pixels(place: Any, canvas: str = "canvas.map") -> str:
    return str(place.evaluate(f"document.querySelector('{canvas}').toDataURL()"))


def colours(place: Any, canvas: str = "canvas.map") -> int:
    """Count the colours on a canvas: one if nothing is drawn."""
    count: int = place.evaluate(
        """(canvas) => { const all = document.querySelector(canvas);
        const { data } = all.getContext('2d').getImageData(0, 0, all.width, all.height);
        return new Set(new Uint32Array(data.buffer)).size; }""",
        canvas,
    )
    return count

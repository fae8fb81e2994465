"""Waits for file descriptors take virtual time (descriptors.py)."""

from alone import run


def test_whoever_waits_lets_the_one_run_who_writes() -> None:
    said = run("""
        import select, selectors, socket
        near, far = socket.socketpair()
        poll, epoll = select.poll(), select.epoll()
        poll.register(far, select.POLLIN); epoll.register(far, select.EPOLLIN)
        selector = selectors.SelectSelector(); selector.register(far, selectors.EVENT_READ)
        for name, look in {
            'select': lambda: select.select([far], [], [], 2)[0],
            'poll': lambda: poll.poll(2000), 'no end': lambda: poll.poll(),
            'epoll': lambda: epoll.poll(2), 'selector': lambda: selector.select(2),
        }.items():
            threading.Timer(0.2, near.send, [b'x']).start()
            say(name, len(look())); far.recv(1)
        say('empty', select.select([far], [], [], 0.5))
    """)
    names = ["select", "poll", "no end", "epoll", "selector"]
    assert said[:5] == [[round(0.2 * (i + 1), 6), name, 1] for i, name in enumerate(names)]
    assert said[5] == [1.5, "empty", [[], [], []]]

"""Futures, tasks, guard conditions and requests: what each state shows, and whom it wakes."""

import threading
import time
from functools import partial
from itertools import product

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.task import Future
from std_srvs.srv import Trigger

SOON, LONG = 0.02, 0.2  # [s]
TIMES = ("at_once", "soon", "soon_elsewhere")
EXECUTORS = (SingleThreadedExecutor, partial(MultiThreadedExecutor, 3))
ENDINGS = {
    "set": lambda future: future.set_result(7),
    "failed": lambda future: future.set_exception(ValueError("no")),
    "cancelled": lambda future: future.cancel(),
    "cancelled, set": lambda future: (future.cancel(), future.set_result(7)),
    "set, cancelled": lambda future: (future.set_result(7), future.cancel()),
    "cancelled, failed": lambda future: (future.cancel(), future.set_exception(ValueError("no"))),
    "pending": lambda future: None,
}


def outcome(call):
    """Return what a call returns, or what it raises."""
    try:
        return repr(call())
    except Exception as error:
        return f"{type(error).__name__}: {error}"


def state(future):
    result = outcome(future.result)
    return f"{future.done()} {future.cancelled()} {result} {future.exception()!r}"


class World:
    """A node, its executor, and what has happened."""

    def __init__(self, make=SingleThreadedExecutor):
        self.log = []
        self.group = ReentrantCallbackGroup()
        self.node = rclpy.create_node("futures")
        self.executor = make()
        self.executor.add_node(self.node)

    def soon(self, act, *arguments):
        """Act from a timer, once."""

        def once():
            timer.cancel()
            act(*arguments)

        timer = self.node.create_timer(SOON, once, callback_group=self.group)

    def soon_elsewhere(self, act, *arguments):
        """Act from another thread."""
        threading.Timer(SOON, act, arguments).start()

    def at_once(self, act, *arguments):
        act(*arguments)

    def spin(self, until=lambda: False):
        end = time.monotonic() + LONG
        while not until() and time.monotonic() < end:
            try:
                self.executor.spin_once(timeout_sec=0.01)
            except Exception as error:
                self.log.append(f"spin raised {error!r}")
        return "in time" if until() else "late"

    async def wait(self, future, name="waiter"):
        self.log.append(f"{name} begins")
        try:
            self.log.append(f"{name} got {await future!r}")
        except ValueError as error:
            self.log.append(f"{name} got {error!r}")
        finally:
            self.log.append(f"{name} ends")

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        return "; ".join(self.log)


def show(name, *words):
    print(name, *words, sep=" | ", flush=True)


def states_without_executor():
    for name, end in ENDINGS.items():
        future, heard = Future(), []
        future.add_done_callback(lambda _, heard=heard: heard.append("before"))
        removed = lambda _, heard=heard: heard.append("removed")  # noqa: E731
        future.add_done_callback(removed)
        show(name, future.remove_done_callback(removed), future.remove_done_callback(removed))
        end(future)
        future.add_done_callback(lambda _, heard=heard: heard.append("after"))
        show(name, state(future), heard)


def waiters():
    for make, (name, end), when in product(EXECUTORS, ENDINGS.items(), TIMES):
        world, future = World(make), Future()
        task = world.executor.create_task(world.wait(future))
        other = world.executor.create_task(world.wait, future, "other")
        getattr(world, when)(end, future)
        ends = world.spin(lambda t=task, o=other: t.done() and o.done())
        show(f"wait {name} {when}", ends, state(task), sorted(world.close().split("; ")))


def spinning_until_complete():
    for make, (name, end), when in product(EXECUTORS, ENDINGS.items(), TIMES[:2]):
        world, future = World(make), Future()
        getattr(world, when)(end, future)
        begin = time.monotonic()
        world.executor.spin_until_future_complete(future, LONG)
        early = time.monotonic() - begin < LONG
        show(f"until complete {name} {when}", early, state(future), world.close())


def tasks():
    def fails():
        raise ValueError("no")

    async def awaits(task):
        return await task

    for make in EXECUTORS:
        for name, body in (("returns", lambda: 3), ("fails", fails)):
            world = World(make)
            task = world.executor.create_task(body)
            task.add_done_callback(lambda done, world=world: world.log.append(state(done)))
            outer = world.executor.create_task(awaits(task))
            ends = world.spin(outer.done)
            world.spin(lambda world=world: len(world.log) > 2)
            show(f"task {name}", ends, state(task), state(outer), sorted(set(world.log)))
            world.close()
        for when in TIMES:
            world, future = World(make), Future()
            task = world.executor.create_task(world.wait(future))
            outer = world.executor.create_task(world.wait(task, "outer"))
            getattr(world, when)(task.cancel)
            ends = world.spin(outer.done)
            future.set_result(7)
            world.spin()
            show(f"task cancelled {when}", ends, state(task), state(outer), task.executing())
            show(f"task cancelled {when}", sorted(world.close().split("; ")))
    world = World()
    task = world.executor.create_task(lambda: world.log.append("ran"))
    task.cancel()
    task.cancel()
    world.spin()
    show("function cancelled before it ran", state(task), world.close())


def serve(world, seconds):
    def answer(request, response):
        time.sleep(seconds)
        response.message = "answer"
        return response

    return world.node.create_service(Trigger, "ask", answer, callback_group=world.group)


REQUESTS = {
    "left alone": lambda world, client, future: None,
    "cancelled": lambda world, client, future: future.cancel(),
    "failed": lambda world, client, future: future.set_exception(ValueError("no")),
    "set": lambda world, client, future: future.set_result(Trigger.Response(message="mine")),
    "removed": lambda world, client, future: client.remove_pending_request(future),
    "removed, cancelled": lambda world, client, future: (
        client.remove_pending_request(future), future.cancel()),
    "client destroyed": lambda world, client, future: world.node.destroy_client(client),
    "client destroyed, cancelled": lambda world, client, future: (
        world.node.destroy_client(client), future.cancel()),
}  # fmt: skip


def requests():
    for (name, act), when in product(REQUESTS.items(), TIMES):
        world = World(EXECUTORS[1])
        serve(world, 3 * SOON)
        client = world.node.create_client(Trigger, "ask", callback_group=world.group)
        future = client.call_async(Trigger.Request())
        future.add_done_callback(lambda _, world=world: world.log.append("called back"))
        task = world.executor.create_task(world.wait(future))
        getattr(world, when)(act, world, client, future)
        ends = world.spin(task.done)
        world.spin()  # the answer comes to nobody
        pending = len(client._pending_requests)
        show(f"request {name} {when}", ends, state(future), pending)
        show(f"request {name} {when}", sorted(world.close().split("; ")))


def calls():
    for name in ("answered", "cancelled", "failed", "timed out", "removed"):
        world = World(EXECUTORS[1])
        if name == "answered":
            serve(world, 0.0)
        client = world.node.create_client(Trigger, "ask", callback_group=world.group)

        def call(client=client, world=world):
            world.log.append(outcome(lambda: client.call(Trigger.Request(), LONG / 2)))

        thread = threading.Thread(target=call)
        thread.start()
        for future in list(client._pending_requests.values()):
            if name in ENDINGS:
                world.soon(ENDINGS[name], future)
            if name == "removed":
                world.soon(client.remove_pending_request, future)
        world.spin(lambda world=world: bool(world.log))
        thread.join()
        show(f"call {name}", world.close(), len(client._pending_requests))


def guards():
    for make in EXECUTORS:
        for when, times in product(TIMES, (1, 2)):
            world = World(make)
            guard = world.node.create_guard_condition(lambda w=world: w.log.append("called"))

            def trigger(guard=guard, times=times):
                for _ in range(times):
                    guard.trigger()

            getattr(world, when)(trigger)
            world.spin()
            show(f"guard {times} {when}", world.close())
        for name, end in ENDINGS.items():
            world, future = World(make), Future()

            async def called(world=world, future=future):
                await world.wait(future)

            guard = world.node.create_guard_condition(called, callback_group=world.group)
            guard.trigger()
            world.soon(end, future)
            world.soon(guard.trigger)
            world.spin(lambda world=world: world.log.count("waiter ends") == 2)
            show(f"guard waits {name}", world.close())
        world = World(make)
        guard = world.node.create_guard_condition(lambda world=world: world.log.append("called"))
        guard.trigger()
        world.soon(world.node.destroy_guard_condition, guard)
        world.spin()
        show("guard destroyed", world.close(), outcome(guard.trigger).split(":")[0])


rclpy.init()
for test in (states_without_executor, waiters, spinning_until_complete, tasks, requests, calls,
             guards):  # fmt: skip
    test()
rclpy.shutdown()

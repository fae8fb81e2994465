"""The robot's ROS node: runs the robot in real time, with its services and parameters.

One executor spins the nodes of both participants; between two steps of the robot it runs the
callbacks that are due.
"""

import math
import time
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from std_srvs.srv import SetBool, Trigger

from sim.errors import InputError
from sim.live.extras import Extras
from sim.live.hearing import Hearing
from sim.live.memory import settling
from sim.live.parameters import Settings, problem_with_rate
from sim.live.robot import LiveRobot, clock_tick
from sim.live.sending import Sender

LOOK = 0.1  # between two polls of what does not wake the executor [s]
REPORT = 1.0  # between two /diagnostics [s]
WARN_EVERY = 10.0  # [s]
INTRODUCTIONS = 0.3  # after the first subscription, until DDS has matched the other endpoints [s]


class MockRobot:
    """A robot and its node.

    Parameters
    ----------
    node
        With its parameters declared.
    stamped_node
        In another participant, for TwistStamped.
    robot
        What the node runs.
    settings
        The values of the parameters.
    extras
        Bag and viewer; the caller closes them.
    """

    def __init__(
        self, node: Any, stamped_node: Any, robot: LiveRobot, settings: Settings, extras: Extras
    ) -> None:
        self._node, self._robot, self._settings = node, robot, settings
        self._viewer = extras.viewer
        self._log = node.get_logger()
        self._sender = Sender(node, robot, extras, clock=settings.clock)
        self._hearing = Hearing(node, stamped_node, robot, extras)
        node.create_service(Trigger, "reset", self._on_reset)
        node.create_service(SetBool, "pause", self._on_pause)
        node.add_on_set_parameters_callback(self._refuse)
        node.add_post_set_parameters_callback(self._obey)
        self._waiting = settings.wait and bool(self._sender.awaited)
        self._paused = False
        self._introduced = math.inf  # when all endpoints are matched, monotonic [s]
        self._reported = time.monotonic()  # when the diagnostics were sent last [s]

    def spin(self, executor: Any, stopped: Callable[[], bool]) -> None:
        """Run until `stopped` says so, or until the scenario is over if the robot ends with it."""
        robot = self._robot
        self._introduce_itself()
        self._go_or_stand()
        behind = False
        while not stopped():
            self._look_around()
            if robot.over and not self._start_over():
                return
            due = robot.due()
            if due > 0:
                executor.spin_once(timeout_sec=min(due, LOOK))
                behind = False
                continue
            self._step()
            if behind:  # commands and services must not wait for a robot that can't keep up
                executor.spin_once(timeout_sec=0.0)
            behind = True

    def _introduce_itself(self) -> None:
        scenario = self._robot.simulation.scenario
        rates = [
            f"{topic} ({rate:g} Hz)" if rate else topic for topic, rate in self._robot.rates.items()
        ]
        self._log.info(
            f"{scenario.name}: sends {', '.join(rates) or 'nothing'}; takes {self._hearing.topic}; "
            f"lidar {scenario.lidar.profile}, seed {scenario.seed}; Ctrl+C ends"
        )
        if self._viewer:
            self._log.info(f"Foxglove: open {self._viewer.url}")
        if self._waiting:
            self._log.info(f"waiting for a subscription to {' or '.join(self._sender.awaited)}")

    def _step(self) -> None:
        messages, slip = self._robot.step()
        if slip:
            self._log.warning(
                f"cannot keep up: {slip * 1e3:.0f} ms late; the scenario's time slips by that much "
                "(see /diagnostics)",
                throttle_duration_sec=WARN_EVERY,
            )
        self._sender.send(messages)

    def _look_around(self) -> None:
        """Do what is due in real time: begin, send /clock while paused, send diagnostics."""
        now = time.monotonic()
        if self._waiting:
            self._watch_for_subscribers(now)
        if now - self._reported < REPORT:
            return
        timeline = self._robot.timeline
        health = self._robot.meter.take(now - self._reported, timeline.rate)
        self._reported = now
        if not timeline.running:
            self._sender.tell_time()
        self._sender.tell_health(health)

    def _watch_for_subscribers(self, now: float) -> None:
        if not self._sender.is_heard():
            self._introduced = math.inf
        elif self._introduced == math.inf:
            self._introduced = now + INTRODUCTIONS
        elif now >= self._introduced:
            self._waiting = False
            self._log.info("subscribed: the scenario begins")
            self._go_or_stand()

    def _go_or_stand(self) -> None:
        self._robot.timeline.run(not self._waiting and not self._paused)

    def _start_over(self) -> bool:
        """Start over at the scenario's end; False if the robot ends with it."""
        seconds = f"{self._robot.simulation.scenario.duration:g} s"
        if self._settings.ends:
            self._log.info(f"{seconds} are over: the robot ends")
            return False
        self._log.warning(f"{seconds} are over: the scenario starts over")
        self._reset()
        return True

    def _reset(self) -> str:
        seed = self._node.get_parameter("seed").value
        with settling():
            simulation = self._robot.planned(seed)
        self._robot.begin(simulation)
        if self._viewer:
            self._viewer.clear()
        text = f"{self._robot.simulation.scenario.name} from its start, seed {seed}"
        self._log.info(text)
        return text

    # --- services and parameters -----------------------------------------------------------------

    def _on_reset(self, request: Any, response: Any) -> Any:
        try:
            response.message = self._reset()
            response.success = True
        except InputError as error:
            response.message, response.success = str(error), False
        return response

    def _on_pause(self, request: Any, response: Any) -> Any:
        self._paused = bool(request.data)
        self._go_or_stand()
        at = f"at {self._robot.timeline.now() / 1e9:.2f} s"
        response.message = f"paused {at}" if self._paused else f"running {at}"
        response.success = True
        return response

    def _refuse(self, parameters: list[Any]) -> Any:
        for parameter in parameters:
            if parameter.name == "rate":
                problem = problem_with_rate(parameter.value, clock=self._settings.clock)
                if problem:
                    return SetParametersResult(successful=False, reason=problem)
        return SetParametersResult(successful=True)

    def _obey(self, parameters: list[Any]) -> None:
        for parameter in parameters:
            if parameter.name == "rate":
                self._robot.timeline.set_rate(parameter.value)
                if self._settings.clock:
                    self._robot.tick = clock_tick(parameter.value)

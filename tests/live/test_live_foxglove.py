"""The scene as a web socket client gets it.

Tests `sim.live.viewer`.
"""

import json
import signal
import socket
import struct
import sys
from collections.abc import Iterator
from typing import Any

import pytest
from processes import LIMIT, Town

from sim.errors import InputError
from sim.live.viewer import Viewer

SUBPROTOCOL = "foxglove.sdk.v1"
MESSAGE_DATA = struct.Struct("<BIQ")  # opcode 1, subscription, time [ns]; then the message


def messages(connection: Any, channels: dict[str, Any]) -> Iterator[tuple[str, bytes]]:
    """Subscribe to all channels; return what comes, topic and payload."""
    topics = list(channels)
    wanted = [{"id": i, "channelId": channels[topic]["id"]} for i, topic in enumerate(topics)]
    connection.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
    while True:
        data = connection.recv()
        if isinstance(data, bytes):
            opcode, subscription, time = MESSAGE_DATA.unpack_from(data)
            assert opcode == 1
            assert time > 0
            yield topics[subscription], data[MESSAGE_DATA.size :]


@pytest.mark.long
def test_a_client_sees_the_scene(here: Town) -> None:
    pytest.importorskip("foxglove")
    websocket = pytest.importorskip("websocket")
    robot = here.robot("--foxglove", "0")
    url = robot.wait_for("Foxglove: open ws://127.0.0.1:").split()[-1]
    here.teleop(0.25, 0.5)
    connection = websocket.create_connection(url, timeout=LIMIT, subprotocols=[SUBPROTOCOL])
    info = json.loads(connection.recv())
    assert (info["op"], info["name"]) == ("serverInfo", "mock_robot")
    channels: dict[str, Any] = {}
    while len(channels) < 5:
        channels |= {c["topic"]: c for c in json.loads(connection.recv())["channels"]}
    assert {topic: channel["schemaName"] for topic, channel in channels.items()} == {
        "/scene": "foxglove.SceneUpdate",
        "/transforms": "foxglove.FrameTransforms",
        "/scan": "foxglove.LaserScan",
        "/odom": "foxglove.PoseInFrame",
        "/cmd_vel": "Command",
    }
    first: dict[str, bytes] = {}
    for topic, payload in messages(connection, channels):
        if topic != "/scene" or b"walls" in payload:
            first.setdefault(topic, payload)
        if len(first) == len(channels):
            break
    assert b"robot" in first["/scene"]
    assert len(first["/scan"]) > 360 * 8
    assert all(frame in first["/transforms"] for frame in (b"map", b"base_link", b"laser"))
    assert json.loads(first["/cmd_vel"]) == {"linear_x": 0.25, "angular_z": 0.5}
    connection.close()
    assert robot.end(signal.SIGINT) == 0
    assert "Traceback" not in robot.rest()


def test_a_port_that_is_taken() -> None:
    pytest.importorskip("foxglove")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(InputError, match=f"--foxglove {port}: cannot serve on 127.0.0.1"):
            Viewer("mock_robot", port)


def test_without_the_sdk_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(InputError, match=r"pip install '\.\[foxglove\]'"):
        Viewer("mock_robot")

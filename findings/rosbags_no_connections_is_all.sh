#!/usr/bin/env bash
# Guess: reader.messages([c for c in reader.connections if c.topic == "/scan"]) reads no message of
#        a bag in which there is no /scan.
# Seen:  it reads every message of every other topic: an empty list is no filter. A generator of the
#        same connections reads none, and neither does the list for a topic that is in the bag and
#        has no message. So a check that counts a topic's messages passes where there is no topic.
# With:  rosbags 0.11.9, both storage plug-ins, 2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install rosbags==0.11.9
cd "$work"
"$work/venv/bin/python" - > "$work/seen" <<'PY'
from pathlib import Path

from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)
kind = "std_msgs/msg/Float64"
for plugin in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
    bag = Path(plugin.name)
    with Writer(bag, version=9, storage_plugin=plugin) as writer:
        speed = writer.add_connection("/speed", kind, typestore=store)
        writer.add_connection("/quiet", kind, typestore=store)
        for time in range(3):
            writer.write(speed, time, store.serialize_cdr(store.types[kind](0.5), kind))
    for reader in (Reader(bag), AnyReader([bag])):
        with reader:
            for topic in ("/speed", "/quiet", "/scan"):
                ends = [end for end in reader.connections if end.topic == topic]
                by_list = [end.topic for end, _, _ in reader.messages(ends)]
                by_generator = [end.topic for end, _, _ in reader.messages(end for end in ends)]
                print(type(reader).__name__, topic, by_list, len(by_generator))
PY
for _ in 1 2; do cat <<'SEEN'; done | diff "$work/seen" - && echo "as it was"
Reader /speed ['/speed', '/speed', '/speed'] 3
Reader /quiet [] 0
Reader /scan ['/speed', '/speed', '/speed'] 0
AnyReader /speed ['/speed', '/speed', '/speed'] 3
AnyReader /quiet [] 0
AnyReader /scan ['/speed', '/speed', '/speed'] 0
SEEN

#!/usr/bin/env bash
# Guess: a bag's end_time is that of its last message, so messages(stop=end) and a duration from the
#        first to the last message fit; `stop` includes that moment as `start` does.
# Seen:  end_time is a nanosecond after the last message and duration one more than their difference;
#        `start` includes, `stop` excludes. Messages of one moment come in the order in which they
#        were written, also where the writer went back in time.
# With:  rosbags 0.11.9, both storage plug-ins, 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install rosbags==0.11.9
cd "$work"
"$work/venv/bin/python" - > "$work/seen" <<'PY'
from pathlib import Path

from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)
kind = "std_msgs/msg/Float64"
for plugin in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
    bag = Path(plugin.name)
    with Writer(bag, version=9, storage_plugin=plugin) as writer:
        ends = {name: writer.add_connection(name, kind, typestore=store) for name in ("/a", "/b")}
        for time, name in ((30, "/a"), (10, "/a"), (20, "/b"), (20, "/a"), (10, "/b")):
            writer.write(ends[name], time, store.serialize_cdr(store.types[kind](0.5), kind))
    with Reader(bag) as reader:
        print([f"{end.topic} {time}" for end, time, _ in reader.messages()])
        print("10 to 20:", len(list(reader.messages(start=10, stop=20))))
        print(reader.start_time, reader.end_time, reader.duration)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
['/a 10', '/b 10', '/b 20', '/a 20', '/a 30']
10 to 20: 2
10 31 21
['/a 10', '/b 10', '/b 20', '/a 20', '/a 30']
10 to 20: 2
10 31 21
SEEN

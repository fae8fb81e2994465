"""A student's own tests, those of docs/testing-your-node.md, where the wheel is installed."""

import re

from person import ROOT, Person

PAGE = (ROOT / "docs" / "testing-your-node.md").read_text("utf-8")
BLOCKS = re.findall(r"(?ms)^```python\n(.*?)^```$", PAGE)
AGENT = ROOT / "solutions" / "obstacle_avoidance" / "obstacle_avoidance_agent.py"


def test_every_test_of_the_page(person: Person) -> None:
    agent = AGENT.read_text("utf-8")
    person.writes({f"test_{n}.py": block for n, block in enumerate(BLOCKS)})
    person.writes({"my_agent.py": agent})
    said = person.types("pytest -W error")
    assert f"{''.join(BLOCKS).count('def test_')} passed" in said
    assert not (person.home / ".course").exists()  # replays are of failures
    person.writes({"my_agent.py": agent.replace("self.cmd_vel_publisher.publish(twist)", "pass")})
    said = person.types("pytest -k each_scan", code=1)
    assert "what the robot did" in said and ".course/replays/test_0-" in said

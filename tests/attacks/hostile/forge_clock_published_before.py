"""Put messages with times of its own into what the host is about to say.

gains: nothing
score: 20
outcome: any
"""

import gc

from kit import attempt, drive


def found(name):
    return [thing for thing in gc.get_objects() if type(thing).__name__ == name]


def turn(node, scan):
    for session in found("Session"):
        for value in vars(session).values():
            if isinstance(value, list) and value:
                with attempt():
                    early = type(value[0])(
                        **{name: getattr(value[0], name) for name in value[0].__struct_fields__}
                        | {"time": 0}
                    )
                    value[:] = [early] * 5


drive(turn)

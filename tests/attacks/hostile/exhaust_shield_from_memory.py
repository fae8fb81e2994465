"""Let the kernel end others first when memory runs out.

gains: nothing
score: 20
outcome: completed
"""

from kit import attempt, drive, gained

for value in ("-1000", "-17", "0"):
    for name in ("oom_score_adj", "oom_adj"):
        with attempt():
            with open(f"/proc/self/{name}", "w") as file:
                file.write(value)
            gained("changes limits and priorities of other processes: shielded from memory's end")
drive()

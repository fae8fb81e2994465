"""One node in one scenario, in virtual or in real time, and the recording of it."""

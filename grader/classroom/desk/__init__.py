"""`course desk`: a page to work in, on this machine, for the instructor and assistants."""

"""Where people change marks: by commands (`marking`, `asked`), or at a page (`server`)."""

"""What the course runs in hosts, beside a student's programs: models, and programs of its own."""

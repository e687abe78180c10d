"""The paper's physics: lone bird, wake, induced velocity, wake force, power. Knows no files and no frames."""

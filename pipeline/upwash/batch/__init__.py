"""Running many jobs: workers, resume, provenance, and what must hold of a results folder."""

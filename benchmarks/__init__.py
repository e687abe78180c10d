"""What is fast, and against what: `make bench`, or `python -m benchmarks [NAME …]`.

Each contest is a module here with a function `contest()` that returns a `Contest`: Upwash first, then its
peers, all given the same work.  They are measured in turns in one process, so that what else the machine does
falls on all of them, and ratios mean something where times do not.  `python -m benchmarks --help` says more.
"""

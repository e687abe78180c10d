"""What people look at, tested on what it shows."""

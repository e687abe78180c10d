"""What people look at, made from stored results: tables, the paper's claims judged, figures, the page."""

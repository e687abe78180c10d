"""Observed birds: tables of where they fly, read, paired, and evaluated row by row."""

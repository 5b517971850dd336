"""Foundations that know no machine: errors, units, compile decorator, frames, steadiness, files."""

"""Scenes that Kinora and other renderers render alike, for tools/compare_outside."""

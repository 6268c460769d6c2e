"""Hostile submissions, each a regression test of our own walls, and what is watched while they run."""

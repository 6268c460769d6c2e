"""Mechanisms by computation: the mathematics of the course, one idea a file."""

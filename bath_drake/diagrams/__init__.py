"""Diagrams: systems wired into closed loops, and what draws and writes them down."""

from bath_drake.diagrams.reproduction import build_perception, build_reproduction

__all__ = ["build_perception", "build_reproduction"]

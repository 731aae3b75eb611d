"""The report of a run: figures and one HTML page."""

from bath_drake.report.page import write_report

__all__ = ["write_report"]

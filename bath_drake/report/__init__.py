"""The report of a run: figures and one HTML page (`page.write_report`)."""

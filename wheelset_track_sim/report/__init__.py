"""What people see of a recorded run: a table, a picture, a page."""

from .figures import plot_run
from .page import write_report
from .table import summary_table

__all__ = ["plot_run", "summary_table", "write_report"]

"""What people see of a recorded run: a table, a picture, a page.

The page, in the module ``page``, needs the extra ``report``.
"""

from .figures import plot_run
from .survey import Survey, survey
from .table import summary_table

__all__ = ["Survey", "plot_run", "summary_table", "survey"]

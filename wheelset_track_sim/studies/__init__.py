"""Parameter studies: one YAML file each, run on all cores or on a cluster, drawn, tabled and summed up.

``Study`` says what is varied and what is kept; ``run_study`` runs it; drawings and tables are made from its results.
"""

from .conduct import Resources, run_study
from .results import Results
from .study import Study, load_study

__all__ = ["Resources", "Results", "Study", "load_study", "run_study"]

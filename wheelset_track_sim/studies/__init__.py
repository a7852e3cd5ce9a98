"""Parameter studies: one YAML file each, run on all cores or on a cluster, drawn, tabled and summed up.

``Study`` says what is varied and what is kept; ``conduct`` runs it; ``write`` draws and writes what came out.
"""

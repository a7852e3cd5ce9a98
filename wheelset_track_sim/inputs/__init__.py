"""What people give: text, YAML, shipped files, and numbers with unit and limits."""

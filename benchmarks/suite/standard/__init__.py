"""Standard problems of optimal control: doorman's examples against solvers that others publish."""

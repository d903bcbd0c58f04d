"""The collision constraints h ≤ 0, one kind a file: plan, check, audit and summary all use these rows."""

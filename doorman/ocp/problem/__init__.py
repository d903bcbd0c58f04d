"""What is to be solved: costs, bounds and terms, in numbers and in symbols."""

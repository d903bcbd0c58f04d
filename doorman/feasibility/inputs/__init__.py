"""Findings from the scenario and its URDFs alone."""

"""Iterations towards a solution: guesses, line searches, rollouts."""

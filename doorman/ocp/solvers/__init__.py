"""Solvers and their solutions."""

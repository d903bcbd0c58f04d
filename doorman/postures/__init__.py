"""Start and goal postures: what a scenario leaves open is found, inside joint limits and constraints and far from them."""

from doorman.postures.proposal import PAPER_POSTURES, Postures, propose, start_arm

__all__ = ["PAPER_POSTURES", "Postures", "propose", "start_arm"]
